// What channels can still take of a path, told from its state and from what the scene can bring.
#include "display/services/foresight/foresight.h"

#include <catch2/catch.hpp>

#include "tests/services/lpe_helpers.h"

namespace raylex::display {
namespace {

using test::build_setup;
using test::Classes;
using test::expression_channel;

struct Scene {
    explicit Scene(std::vector<ChannelDefinition> asked)
        : channels(std::move(asked)),
          setup(build_setup(channels, invalid_channel)),
          classes(setup),
          table(channels, 1, 0),
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

TEST_CASE("what is ahead of a path is read from its state", "[foresight][law4]") {
    Scene scene({expression_channel("direct", "C<RD>L"), expression_channel("caustic", "C<RD><RS>+L"),
                 expression_channel("sky", "C<RS>B")});
    const Classes& c = scene.classes;
    const Foresight foresight(scene.setup, {{c.diffuse, c.singular}, {}, {c.light, c.background}, {}, 0});
    const std::uint64_t light = foresight.bit_of(c.light), sky = foresight.bit_of(c.background);
    CHECK(light != sky);
    Tracker tracker = scene.services.begin(0);
    Foresight::Ahead ahead = foresight.of(tracker);
    CHECK(ahead.anything);
    CHECK(ahead.scatters);
    CHECK(ahead.terminals == 0);
    ahead = foresight.after(tracker, std::array{c.diffuse});
    CHECK(ahead.anything);
    CHECK(ahead.scatters);
    CHECK(ahead.terminals == (light | sky));  // L takes infinite lights too
    ahead = foresight.after(tracker, std::array{c.singular});
    CHECK(ahead.anything);
    CHECK_FALSE(ahead.scatters);
    CHECK(ahead.terminals == sky);
    CHECK(foresight.after(tracker, std::array{c.diffuse, c.singular}).terminals == (light | sky));
    CHECK_FALSE(foresight.after(tracker, std::array{c.diffuse_through}).anything);
    scene.services.move(tracker, c.diffuse);
    CHECK(foresight.after(tracker, std::array{c.singular}).scatters);
    CHECK_FALSE(foresight.after(tracker, std::array{c.diffuse}).anything);
    const std::vector<std::uint64_t> sets = foresight.sets_of_terminals();
    CHECK(std::find(sets.begin(), sets.end(), sky) != sets.end());
    CHECK(Foresight().after(tracker, std::array{c.diffuse}).anything);  // it knows nothing
}

TEST_CASE("what is ahead at the camera is told without a path", "[foresight][law4]") {
    const auto at_camera = [](const char* expression) {
        const Scene scene({expression_channel("asked", expression)});
        const Classes& c = scene.classes;
        return Foresight(scene.setup, {{c.diffuse}, {}, {c.light}, {}, 0}).at_camera();
    };
    CHECK(at_camera("CL").anything);
    CHECK_FALSE(at_camera("CL").scatters);
    CHECK(at_camera("C<RD>*L").scatters);
    CHECK(at_camera("C<RD>*L").terminals != 0);
    CHECK(at_camera("C<RD>+L").terminals == 0);
    CHECK_FALSE(at_camera("C<RS>L").anything);  // which the scene does not bring
    CHECK(Foresight().at_camera().scatters);    // it knows nothing
}

TEST_CASE("what a scene cannot bring is not waited for", "[foresight][law4]") {
    Scene scene({expression_channel("through", "C<TS>.*L"), expression_channel("sky", "C<RD>B")});
    const Classes& c = scene.classes;
    const Tracker tracker = scene.services.begin(0);
    CHECK(scene.services.live(tracker));
    const auto anything = [&](const Foresight::Alphabet& alphabet) {
        return Foresight(scene.setup, alphabet).of(tracker).anything;
    };
    CHECK(anything({{c.diffuse, c.singular_through}, {}, {c.light}, {}, 0}));
    CHECK_FALSE(anything({{c.diffuse, c.singular}, {}, {c.light}, {}, 0}));  // no glass, no sky
    CHECK(anything({{c.diffuse}, {}, {c.light, c.background}, {}, 0}));
    CHECK_FALSE(anything({{c.singular_through}, {}, {}, {}, 0}));  // no lights
}

TEST_CASE("cutouts and what surfaces say of themselves are foreseen", "[foresight][law4]") {
    ChannelDefinition behind = expression_channel("behind", "C<T[s]><RD>L");
    behind.dialect = lpe::Dialect::osl;
    Scene scene({behind, expression_channel("albedo", "C<RD>U2L")});
    const Classes& c = scene.classes;
    const lpe::EventClass straight =
        scene.setup.classify({lpe::EventType::transmission, lpe::Scatter::straight, 0, {"", ""}});
    lpe::Event said{lpe::EventType::user, lpe::Scatter::none, 2, {"", ""}};
    const lpe::EventClass user = scene.setup.classify(said);
    Tracker tracker = scene.services.begin(0);
    const Foresight with(scene.setup, {{c.diffuse}, {straight}, {c.light}, {}, 0});
    CHECK(with.of(tracker).anything);
    CHECK(with.of(tracker).scatters);
    CHECK_FALSE(with.after(tracker, std::array{c.diffuse}).anything);
    const Foresight talking(scene.setup, {{c.diffuse}, {}, {c.light}, {user}, c.light});
    CHECK(talking.after(tracker, std::array{c.diffuse}).anything);
    CHECK_FALSE(talking.after(tracker, std::array{c.diffuse}).scatters);
}

}  // namespace raylex::display
