// What channels can still take of a path, by its state and by the events that the scene can bring.
#include "display/services/liveness/liveness.h"

#include <catch2/catch.hpp>

#include <array>
#include <memory>

#include "tests/lpe/oracle.h"
#include "tests/services/lpe_helpers.h"

namespace raylex::display {
namespace {

using test::build_setup;
using test::Classes;
using test::expression_channel;
using test::join;

struct Scene {
    explicit Scene(std::vector<ChannelDefinition> asked)
        : channels(std::move(asked)),
          setup(build_setup(channels, invalid_channel)),
          classes(setup),
          table(channels, 1),
          services(setup, table, 1) {
        table.begin(test::pixel_rows(0, 0, 0, 1));
    }
    std::vector<ChannelDefinition> channels;
    LpeSetup setup;
    Classes classes;
    SampleTable table;
    LpeServices services;
};

}  // namespace

TEST_CASE("the state of a path determines what is live", "[liveness][law4]") {
    Scene scene({expression_channel("direct", "C<RD>L"), expression_channel("caustic", "C<RD><RS>+L"),
                 expression_channel("sky", "C<RS>B")});
    const Classes& c = scene.classes;
    const Liveness liveness(scene.setup, {{c.diffuse, c.singular}, {}, {c.light, c.background}, {}, 0});
    const std::uint64_t light = liveness.bit_of(c.light), sky = liveness.bit_of(c.background);
    CHECK(light != sky);
    Tracker tracker = scene.services.begin(0);
    Liveness::LiveSet live = liveness.of(tracker);
    CHECK(live.anything);
    CHECK(live.scatters);
    CHECK(live.terminals == 0);
    live = liveness.after(tracker, std::array{c.diffuse});
    CHECK(live.anything);
    CHECK(live.scatters);
    CHECK(live.terminals == (light | sky));  // L takes infinite lights too
    live = liveness.after(tracker, std::array{c.singular});
    CHECK(live.anything);
    CHECK_FALSE(live.scatters);
    CHECK(live.terminals == sky);
    CHECK(liveness.after(tracker, std::array{c.diffuse, c.singular}).terminals == (light | sky));
    CHECK_FALSE(liveness.after(tracker, std::array{c.diffuse_through}).anything);
    scene.services.move(tracker, c.diffuse);
    CHECK(liveness.after(tracker, std::array{c.singular}).scatters);
    CHECK_FALSE(liveness.after(tracker, std::array{c.diffuse}).anything);
    const std::vector<std::uint64_t> sets = liveness.sets_of_terminals();
    CHECK(std::find(sets.begin(), sets.end(), sky) != sets.end());
    CHECK(Liveness().after(tracker, std::array{c.diffuse}).anything);  // nothing is known
}

TEST_CASE("liveness at the camera needs no path", "[liveness][law4]") {
    const auto at_camera = [](const char* expression) {
        const Scene scene({expression_channel("asked", expression)});
        const Classes& c = scene.classes;
        return Liveness(scene.setup, {{c.diffuse}, {}, {c.light}, {}, 0}).at_camera();
    };
    CHECK(at_camera("CL").anything);
    CHECK_FALSE(at_camera("CL").scatters);
    CHECK(at_camera("C<RD>*L").scatters);
    CHECK(at_camera("C<RD>*L").terminals != 0);
    CHECK(at_camera("C<RD>+L").terminals == 0);
    CHECK_FALSE(at_camera("C<RS>L").anything);  // which the scene does not bring
    CHECK(Liveness().at_camera().scatters);     // nothing is known
}

TEST_CASE("events that a scene cannot bring keep nothing live", "[liveness][law4]") {
    Scene scene({expression_channel("through", "C<TS>.*L"), expression_channel("sky", "C<RD>B")});
    const Classes& c = scene.classes;
    const Tracker tracker = scene.services.begin(0);
    CHECK(scene.services.live(tracker));
    const auto anything = [&](const Liveness::Alphabet& alphabet) {
        return Liveness(scene.setup, alphabet).of(tracker).anything;
    };
    CHECK(anything({{c.diffuse, c.singular_through}, {}, {c.light}, {}, 0}));
    CHECK_FALSE(anything({{c.diffuse, c.singular}, {}, {c.light}, {}, 0}));  // no glass, no sky
    CHECK(anything({{c.diffuse}, {}, {c.light, c.background}, {}, 0}));
    CHECK_FALSE(anything({{c.singular_through}, {}, {}, {}, 0}));  // no lights
}

TEST_CASE("cutouts and user events keep channels live", "[liveness][law4]") {
    ChannelDefinition behind = expression_channel("behind", "C<T[s]><RD>L");
    behind.dialect = lpe::Dialect::osl;
    Scene scene({behind, expression_channel("albedo", "C<RD>U2L")});
    const Classes& c = scene.classes;
    const lpe::EventClass straight =
        scene.setup.classify({lpe::EventType::transmission, lpe::Scatter::straight, 0, {"", ""}});
    lpe::Event said{lpe::EventType::user, lpe::Scatter::none, 2, {"", ""}};
    const lpe::EventClass user = scene.setup.classify(said);
    Tracker tracker = scene.services.begin(0);
    const Liveness with(scene.setup, {{c.diffuse}, {straight}, {c.light}, {}, 0});
    CHECK(with.of(tracker).anything);
    CHECK(with.of(tracker).scatters);
    CHECK_FALSE(with.after(tracker, std::array{c.diffuse}).anything);
    const Liveness talking(scene.setup, {{c.diffuse}, {}, {c.light}, {user}, c.light});
    CHECK(talking.after(tracker, std::array{c.diffuse}).anything);
    CHECK_FALSE(talking.after(tracker, std::array{c.diffuse}).scatters);
}

TEST_CASE("liveness of bit-parallel channels is the union of that of each channel alone",
          "[liveness][bit-parallel][law4]") {
    const auto label = [](std::size_t k) { return "obj" + std::to_string(k); };
    std::vector<ChannelDefinition> channels;
    const auto family = [&](const std::string& expression) {
        for (std::size_t k = 0; k < 24; ++k) {
            std::string text;
            for (const char c : expression) text += c == '@' ? label(k) : std::string(1, c);
            channels.push_back(expression_channel(join({"c", std::to_string(channels.size())}), text));
        }
    };
    family("C.*<RD'@'>.*<L.'key'>");  // automata of two codes
    family("C.*<RS'@'>.*L");          // more than one word of them
    family("C.*<RD'@'><RS>.*L");      // of four
    family("C.*<RD'@'>..<L.'key'>");  // of eight
    family("C.*<RS'@'>.*<RD'@'>.B");  // the scene has no sky in its second alphabet
    channels.push_back(expression_channel("table", "C<RS>{2}<L.'fill'>"));
    channels.push_back(expression_channel("spoken", "C.*<RD'obj3'>U2L"));
    Scene together(channels);
    const auto& widths = together.setup.program().view().widths;
    REQUIRE(widths[0].words > 1);
    for (std::size_t bits = 1; bits <= lpe::ProgramView::parallel_widths; ++bits) REQUIRE(widths[bits - 1].words > 0);
    std::vector<std::unique_ptr<Scene>> alone;
    for (const ChannelDefinition& channel : channels) {
        alone.push_back(std::make_unique<Scene>(std::vector<ChannelDefinition>{channel}));
        REQUIRE_FALSE(alone.back()->setup.program().view().has_parallel());
    }

    using lpe::EventType;
    using lpe::Scatter;
    std::vector<lpe::Event> scatterings, terminals;
    for (std::size_t k = 0; k < 24; ++k)
        for (const Scatter how : {Scatter::diffuse, Scatter::singular})
            scatterings.push_back({EventType::reflection, how, 0, {label(k), ""}});
    const lpe::Event straight{EventType::transmission, Scatter::straight, 0, {"", ""}};
    const lpe::Event said{EventType::user, Scatter::none, 2, {"", ""}};
    for (const char* group : {"key", "fill", ""}) terminals.push_back({EventType::light, Scatter::none, 0, {group}});
    terminals.push_back({EventType::background, Scatter::none, 0, {""}});

    std::size_t some = 0, scattering = 0, lit = 0, dead = 0;
    for (const auto& reduced : {std::pair{false, false}, {true, false}, {true, true}}) {
        const bool poor = reduced.first, bare = reduced.second;
        // Poor: half of the objects, no sky, no cutouts, and nobody speaks. Bare: nothing scatters any more.
        const std::size_t objects = poor ? scatterings.size() / 2 : scatterings.size();
        const auto liveness_of = [&](const LpeSetup& setup) {
            Liveness::Alphabet alphabet;
            for (std::size_t i = 0; i < (bare ? 0 : objects); ++i)
                alphabet.scatterings.push_back(setup.classify(scatterings[i]));
            for (std::size_t i = 0; i < terminals.size() - (poor ? 1 : 0); ++i)
                alphabet.terminals.push_back(setup.classify(terminals[i]));
            alphabet.user_terminal = setup.classify(terminals[2]);
            if (!poor) alphabet.straight.push_back(setup.classify(straight));
            if (!poor) alphabet.user.push_back(setup.classify(said));
            return Liveness(setup, alphabet);
        };
        const Liveness liveness = liveness_of(together.setup);
        std::vector<Liveness> each;
        for (const auto& one : alone) each.push_back(liveness_of(one->setup));
        const auto lights = [&](const Liveness& of, const LpeSetup& setup, const Liveness::LiveSet& live) {
            unsigned bits = 0;
            for (std::size_t i = 0; i < terminals.size() - (poor ? 1 : 0); ++i)
                bits |= (live.terminals & of.bit_of(setup.classify(terminals[i]))) != 0 ? 1U << i : 0U;
            return bits;
        };
        const auto check = [&](const auto& ask) {
            const Liveness::LiveSet live = ask(liveness, together);
            bool anything = false, scatters = false;
            unsigned bits = 0;
            for (std::size_t i = 0; i < alone.size(); ++i) {
                const Liveness::LiveSet one = ask(each[i], *alone[i]);
                anything |= one.anything;
                scatters |= one.scatters;
                bits |= lights(each[i], alone[i]->setup, one);
            }
            CHECK(live.anything == anything);
            CHECK(live.scatters == scatters);
            CHECK(lights(liveness, together.setup, live) == bits);
            // Where paths come by what the scene has.
            if (!bare) CHECK((live.terminals & ~liveness.live_terminals()) == 0);
            some += live.anything;
            scattering += live.scatters;
            lit += live.terminals != 0;
            dead += !live.anything;
        };
        check([](const Liveness& of, Scene&) { return of.at_camera(); });
        oracle::Random random(poor ? 8 : 7);
        for (int path = 0; path < 60; ++path) {
            std::vector<lpe::Event> events;
            for (std::size_t length = random.below(5); length > 0; --length) {
                const bool through = !poor && random.below(8) == 0;
                events.push_back(through ? straight : scatterings[random.below(objects)]);
            }
            if (random.below(10) == 0) events.push_back(terminals[0]);  // nothing is live of it
            const auto tracker = [&](Scene& scene) {
                Tracker at = scene.services.begin(0);
                for (const lpe::Event& event : events) scene.services.move(at, scene.setup.classify(event));
                return at;
            };
            const lpe::Event& first = scatterings[random.below(objects)];
            const lpe::Event& second = scatterings[random.below(objects)];
            check([&](const Liveness& of, Scene& scene) { return of.of(tracker(scene)); });
            check([&](const Liveness& of, Scene& scene) {
                return of.after(tracker(scene), std::array{scene.setup.classify(first), scene.setup.classify(second)});
            });
        }
    }
    for (const std::size_t count : {some, scattering, lit, dead}) CHECK(count > 10);
}

TEST_CASE("lights at the end of path strings of other scenes are not live", "[liveness][bit-parallel][law4]") {
    const auto ever = [](bool packed, const std::vector<const char*>& more, bool speaks) {
        std::vector<ChannelDefinition> channels;
        for (int k = 0; k < (packed ? 24 : 1); ++k)
            channels.push_back(
                expression_channel(join({"c", std::to_string(k)}), "C.*<RD'obj" + std::to_string(k) + "'>.*<L.'key'>"));
        for (const char* expression : more) channels.push_back(expression_channel(expression, expression));
        const LpeSetup setup = build_setup(channels, invalid_channel);
        REQUIRE(setup.program().view().has_parallel() == packed);
        const auto classify = [&](lpe::EventType type, lpe::Scatter how, const char* label) {
            return setup.classify({type, how, 0, {label, ""}});
        };
        Liveness::Alphabet alphabet;
        for (const char* label : {"obj0", "obj1", "floor"})
            alphabet.scatterings.push_back(classify(lpe::EventType::reflection, lpe::Scatter::diffuse, label));
        const lpe::EventClass key = classify(lpe::EventType::light, lpe::Scatter::none, "key"),
                              rim = classify(lpe::EventType::light, lpe::Scatter::none, "rim");
        alphabet.terminals = {key, rim};
        alphabet.user_terminal = classify(lpe::EventType::light, lpe::Scatter::none, "");
        if (speaks) alphabet.user.push_back(setup.classify({lpe::EventType::user, lpe::Scatter::none, 2, {"", ""}}));
        const Liveness liveness(setup, alphabet);
        CHECK((liveness.live_terminals() & liveness.bit_of(key)) != 0);
        return (liveness.live_terminals() & liveness.bit_of(rim)) != 0;
    };
    for (const bool packed : {false, true}) {
        CAPTURE(packed);
        CHECK_FALSE(ever(packed, {}, false));
        CHECK_FALSE(ever(packed, {"C.*<RD'nobody'>.*L", "C.*<RS>L"}, false));
        CHECK_FALSE(ever(packed, {"C.*U2L"}, true));
        CHECK(ever(packed, {"C<RD'floor'>L"}, false));
    }
}

}  // namespace raylex::display
