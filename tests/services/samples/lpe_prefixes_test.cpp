#include <array>
#include <limits>

#include <catch2/catch.hpp>

#include "display/services/samples/lpe_services.h"
#include "display/services/samples/sample_filter.h"
#include "tests/services/lpe_helpers.h"

namespace raylex::display {
namespace {

using test::build_setup;
using test::Classes;
using test::expression_channel;
using test::plain_channel;

constexpr float not_finite = std::numeric_limits<float>::infinity();

/// The channel beauty, then one channel "c<i>" per expression; one camera sample.
struct Splatted {
    explicit Splatted(const std::vector<std::string>& expressions, bool with_beauty = true)
        : channels(make(expressions)),
          setup(build_setup(channels, with_beauty ? 0 : invalid_channel)),
          classes(setup),
          table(channels, 2),
          services(setup, table, 5) {
        table.begin(test::pixel_rows(0, 0, 0, 2));
    }
    static std::vector<ChannelDefinition> make(const std::vector<std::string>& expressions) {
        std::vector<ChannelDefinition> result{plain_channel("beauty", ChannelType::rgb)};
        for (const std::string& expression : expressions)
            result.push_back(expression_channel(test::join({"c", std::to_string(result.size())}), expression));
        return result;
    }
    Tracker path(std::initializer_list<lpe::EventClass> events) {
        Tracker tracker = services.begin(0);
        for (const lpe::EventClass event : events) services.move(tracker, event);
        return tracker;
    }
    [[nodiscard]] double red(ChannelId id) const { return table.values(id)[0]; }

    std::vector<ChannelDefinition> channels;
    LpeSetup setup;
    Classes classes;
    SampleTable table;
    LpeServices services;
};

EmitterSample light_sample(float emitted, float unweighted, float visibility) {
    return {Rgb(emitted), Rgb(unweighted), visibility, false};
}

}  // namespace

TEST_CASE("a light sample counts in full for unoccluded channels, blocked or not; the blocked part is the shadow",
          "[prefixes]") {
    Splatted s({"C<RD>L", "unoccluded;C<RD>L", "shadows;C<RD>L", "nothruput;C<RD>L", "nothruput;unoccluded;C<RD>L",
                "nothruput;shadows;C<RD>L"});
    CHECK(s.services.wants_emitter_samples());
    const Tracker lit = s.path({s.classes.diffuse, s.classes.light});
    // The light emits 8; with an MIS weight of 1 and no occluder 2 would arrive; 0.5 arrives with an MIS weight of 1/2
    // through a half open door.
    s.services.contribute(Rgb(0.5f), Technique{1, 2}, lit, light_sample(8, 2, 0.5f));
    const std::array<double, 7> half{0.5, 0.5, 2, 1, 4, 8, 4};
    for (ChannelId id = 0; id < 7; ++id) CHECK(s.red(id) == half[static_cast<std::size_t>(id)]);
    // The same sample behind a wall.
    s.services.contribute(Rgb(0), Technique{1, 2}, lit, light_sample(8, 2, 0));
    const std::array<double, 7> blocked{0.5, 0.5, 4, 3, 4, 16, 12};
    for (ChannelId id = 0; id < 7; ++id) CHECK(s.red(id) == blocked[static_cast<std::size_t>(id)]);
}

TEST_CASE("unoccluded channels take an emitter only from light sampling if that finds it, too", "[prefixes]") {
    Splatted s({"C<RD>L", "unoccluded;C<RD>L", "shadows;C<RD>L", "nothruput;C<RD>L"});
    const Tracker hit = s.path({s.classes.diffuse, s.classes.light});
    s.services.contribute(Rgb(0.25f), Technique{}, hit, {Rgb(8), Rgb(1), 1, true});
    const std::array<double, 5> sampled_too{0.25, 0.25, 0, 0, 8};
    for (ChannelId id = 0; id < 5; ++id) CHECK(s.red(id) == sampled_too[static_cast<std::size_t>(id)]);
    s.services.contribute(Rgb(1), Technique{}, hit, {Rgb(8), Rgb(1), 1, false});
    const std::array<double, 5> by_chance_alone{1.25, 1.25, 1, 0, 16};
    for (ChannelId id = 0; id < 5; ++id) CHECK(s.red(id) == by_chance_alone[static_cast<std::size_t>(id)]);
}

TEST_CASE("a technique as prefix takes the technique's contributions, with or without MIS weights", "[prefixes]") {
    Splatted s({"s1t2;C<RD>L", "s1t2;unweighted;C<RD>L", "s0t3;C<RD>L", "beyond3;C.*L", "unweighted;C<RD>L", "C<RD>L"});
    CHECK(s.services.wants_emitter_samples());
    CHECK(s.setup.needs_emitter_samples() == invalid_channel);  // an integrator without emitter samples gives values
                                                                // for both
    const Tracker lit = s.path({s.classes.diffuse, s.classes.light});
    s.services.contribute(Rgb(0.5f), {1, 2}, lit, light_sample(8, 2, 0.5f));
    s.services.contribute(Rgb(0.25f), {0, 3}, lit, {Rgb(8), Rgb(1), 1, true});
    const std::array<double, 7> direct{0.75, 0.5, 1, 0.25, 0, 2, 0.75};
    for (ChannelId id = 0; id < 7; ++id) CHECK(s.red(id) == direct[static_cast<std::size_t>(id)]);
    s.services.contribute(Rgb(4), {2, 2}, s.path({s.classes.diffuse, s.classes.diffuse, s.classes.light}));
    CHECK(s.red(4) == 4);
    CHECK(s.red(1) == 0.5);

    for (const char* refused : {"s1t2;s0t3;C.*", "unweighted;unoccluded;C.*", "nothruput;unweighted;C.*"})
        CHECK_FALSE(read_prefixes(expression_channel("x", refused)).ok());
    for (const char* unknown : {"s1t0;C.*", "st;C.*", "s1;C.*", "beyond;C.*", "s1t2x;C.*", "s1t10000;C.*"}) {
        const auto read = read_prefixes(expression_channel("x", unknown));
        REQUIRE_FALSE(read.ok());
        CHECK(read.error().message.find("a technique such as s2t3 or beyond7") != std::string::npos);
    }
}

TEST_CASE("overwrite keeps the last contribution in full, and a black one replaces nothing", "[prefixes]") {
    Splatted s({"overwrite;C.*L", "C.*L"});
    CHECK_FALSE(s.services.wants_emitter_samples());
    s.services.contribute(Rgb(1), Technique{}, s.path({s.classes.light}));
    s.services.contribute(Rgb(2), Technique{}, s.path({s.classes.diffuse, s.classes.light}));
    s.services.contribute(Rgb(0), Technique{}, s.path({s.classes.diffuse, s.classes.light}));
    s.services.contribute(Rgb(5), Technique{}, s.path({s.classes.diffuse, s.classes.background}));
    CHECK(s.red(1) == 5);
    CHECK(s.red(2) == 8);
    CHECK(s.red(0) == 8);
    // The other camera sample keeps its own value.
    Tracker other = s.services.begin(1);
    s.services.move(other, s.classes.light);
    s.services.contribute(Rgb(3), Technique{}, other);
    CHECK(s.red(1) == 5);
    CHECK(s.table.values(1)[3] == 3);
}

TEST_CASE("the shares of overlapping lobes in one contribution are one splat for overwrite", "[prefixes][law5]") {
    Splatted s({"overwrite;C[<RD><RG>]L", "overwrite;C<RD>L", "overwrite;C<RG>L"});
    for (const float value : {1.0f, 4.0f}) {
        Tracker tracker = s.services.begin(0);
        const std::array<LobePart, 2> parts{{{s.classes.diffuse, Rgb(0.25f)}, {s.classes.glossy, Rgb(0.75f)}}};
        s.services.move(tracker, parts);
        s.services.move(tracker, s.classes.light);
        s.services.contribute(Rgb(value), Technique{}, tracker);
    }
    CHECK(s.red(1) == 4);
    CHECK(s.red(2) == 1);
    CHECK(s.red(3) == 3);
}

TEST_CASE("shares also split channels without throughput, so that they sum", "[prefixes][law5]") {
    Splatted s({"nothruput;C.*", "nothruput;C<RD>.*", "nothruput;C<RG>.*"});
    Tracker tracker = s.services.begin(0);
    const std::array<LobePart, 2> parts{{{s.classes.diffuse, Rgb(0.25f)}, {s.classes.glossy, Rgb(0.75f)}}};
    s.services.move(tracker, parts);
    s.services.move(tracker, s.classes.light);
    s.services.contribute(Rgb(1), Technique{}, tracker, {Rgb(8), Rgb(1), 1, false});
    CHECK(s.red(1) == 8);
    CHECK(s.red(2) == 2);
    CHECK(s.red(3) == 6);
}

TEST_CASE("a channel without infinity check depends on its own value, and never contains infinities",
          "[prefixes][law6]") {
    Splatted s({"C.*", "nothruput;C.*", "nothruput;noinfinitecheck;C.*", "noinfinitecheck;C.*"});
    const Tracker seen = s.path({s.classes.light});
    s.services.contribute(Rgb(not_finite), Technique{}, seen, {Rgb(8), Rgb(not_finite), 1, false});
    const std::array<double, 5> checked{0, 0, 0, 8, 0};
    for (ChannelId id = 0; id < 5; ++id) CHECK(s.red(id) == checked[static_cast<std::size_t>(id)]);
    CHECK(s.services.invalid_count() == 1);
    // Beauty's value is valid, the channels' own values are not: they are dropped, beauty keeps its value, and it
    // counts once.
    s.services.contribute(Rgb(1), Technique{}, seen, {Rgb(not_finite), Rgb(1), 1, false});
    const std::array<double, 5> own{1, 1, 0, 8, 1};
    for (ChannelId id = 0; id < 5; ++id) CHECK(s.red(id) == own[static_cast<std::size_t>(id)]);
    CHECK(s.services.invalid_count() == 2);
    CHECK(s.table.invalid_log()[1].value.r == not_finite);
}

TEST_CASE("paths that begin at a holdout go to holdouts channels and nowhere else", "[prefixes][law1]") {
    Splatted s({"C.*", "C<RD>.*", "C[^<RD>].*|C", "holdouts;C.*", "unoccluded;holdouts;C.*"});
    Tracker ordinary = s.path({s.classes.diffuse, s.classes.light});
    s.services.contribute(Rgb(2), Technique{1, 2}, ordinary, light_sample(1, 3, 1));
    const std::array<double, 6> before{2, 2, 2, 0, 0, 0};
    for (ChannelId id = 0; id < 6; ++id) CHECK(s.red(id) == before[static_cast<std::size_t>(id)]);
    Tracker held = s.services.begin(0);
    CHECK(s.services.takes_all(held));
    s.services.hold_out(held);
    CHECK_FALSE(s.services.takes_all(held));
    CHECK(s.services.live(held));
    s.services.move(held, s.classes.diffuse);
    Tracker lit = held;  // a copy is held out, too
    s.services.move(lit, s.classes.light);
    s.services.contribute(Rgb(5), Technique{1, 2}, lit, light_sample(1, 7, 0.5f));
    const std::array<double, 6> after{2, 2, 2, 0, 5, 7};
    for (ChannelId id = 0; id < 6; ++id) CHECK(s.red(id) == after[static_cast<std::size_t>(id)]);
}

TEST_CASE("a held out path that no holdouts channel can take is dead", "[prefixes][law4]") {
    Splatted none({"C.*"});
    Tracker tracker = none.services.begin(0);
    none.services.hold_out(tracker);
    CHECK_FALSE(none.services.live(tracker));
    CHECK_FALSE(none.services.live_after(tracker, none.classes.diffuse));
    none.services.move(tracker, none.classes.light);
    none.services.contribute(Rgb(1), Technique{}, tracker);
    CHECK(none.red(0) == 0);
    CHECK(none.red(1) == 0);

    Splatted some({"C.*", "holdouts;C<RD>L"}, false);
    Tracker held = some.services.begin(0), plain = some.services.begin(0);
    some.services.hold_out(held);
    CHECK(some.services.live(held));
    CHECK(some.services.live_after(held, some.classes.diffuse));
    CHECK_FALSE(some.services.live_after(held, some.classes.glossy));  // only C.* is reached, not the path's own
                                                                       // channel
    CHECK(some.services.live_after(plain, some.classes.glossy));
    some.services.move(held, some.classes.glossy);
    CHECK_FALSE(some.services.live(held));

    Splatted holdouts_only({"holdouts;C<RD>L"}, false);
    Tracker path = holdouts_only.services.begin(0);
    CHECK_FALSE(holdouts_only.services.live_after(path, holdouts_only.classes.diffuse));
}

TEST_CASE("no shadow ray is needed if only unoccluded channels take the light", "[prefixes][law4]") {
    Splatted s({"unoccluded;C<RD>L", "C<RG>L"}, false);
    CHECK_FALSE(s.services.needs_visibility(s.path({s.classes.diffuse, s.classes.light})));
    CHECK(s.services.needs_visibility(s.path({s.classes.glossy, s.classes.light})));
    Splatted with_beauty({"unoccluded;C<RD>L"});
    CHECK(with_beauty.services.needs_visibility(
        with_beauty.path({with_beauty.classes.diffuse, with_beauty.classes.light})));
}

TEST_CASE("a surface's own values reach the channels that name them, and never beauty", "[prefixes]") {
    Splatted s({"nothruput;overwrite;C(U2L)|O", "C.*U2L", "C.*", "nothruput;holdouts;CU2L"});
    const auto user = [&](std::uint8_t number) {
        return s.setup.classify({lpe::EventType::user, lpe::Scatter::none, number, {"", ""}});
    };
    CHECK(s.setup.follows(user(2)));
    CHECK_FALSE(s.setup.follows(user(3)));
    CHECK_FALSE(Splatted({"C.*"}).setup.follows(s.classes.light));
    s.services.contribute_user(Rgb(0.5f), Rgb(1), s.path({user(2), s.classes.light}));
    s.services.contribute_user(Rgb(0.75f), Rgb(0.5f), s.path({s.classes.diffuse, user(2), s.classes.light}));
    const std::array<double, 5> taken{0, 0.5, 0.5 + 0.375, 0, 0};
    for (ChannelId id = 0; id < 5; ++id) CHECK(s.red(id) == taken[static_cast<std::size_t>(id)]);
}

TEST_CASE("channels without prefixes have the same bits with and without channels that have them", "[prefixes][law2]") {
    const auto run = [](const std::vector<std::string>& expressions) {
        Splatted s(expressions);
        test::Random random(3);
        for (int i = 0; i < 500; ++i) {
            Tracker tracker = s.services.begin(0);
            const auto color = [&] {
                return Rgb(random.uniform_float(), random.uniform_float(), random.uniform_float());
            };
            for (int k = random.below(4); k > 0; --k) {
                const std::array<LobePart, 2> parts{{{s.classes.diffuse, color()}, {s.classes.glossy, color()}}};
                s.services.move(tracker, parts);
            }
            s.services.move(tracker, s.classes.light);
            const Rgb value = i % 50 == 0 ? Rgb(not_finite) : color();
            s.services.contribute(value, Technique{}, tracker, {color(), color(), random.uniform_float(), false});
        }
        return std::vector<double>(s.table.raw_values(0),
                                   s.table.raw_values(0) + 3 * 2 * 4);  // beauty and the first three channels
    };
    std::vector<std::string> expressions{"C<RD>.*", "noclamp;C<RG>.*", "CL"};
    const std::vector<double> alone = run(expressions);
    for (const char* more : {"unoccluded;C.*", "shadows;C<RD>.*", "nothruput;overwrite;C.*", "holdouts;C.*",
                             "noinfinitecheck;nothruput;C<RG>.*"})
        expressions.push_back(more);
    CHECK(run(expressions) == alone);
}

TEST_CASE("prefixes that contradict each other are refused by name", "[prefixes][law7]") {
    std::vector<ChannelDefinition> channels{plain_channel("beauty", ChannelType::rgb),
                                            expression_channel("mine", "unoccluded;noclamp;shadows;C<RD>L")};
    channels[1].origin = "job.toml";
    channels[1].origin_line = 8;
    const auto setup = LpeSetup::build(channels, 0);
    REQUIRE_FALSE(setup);
    CHECK(setup.error().message.find("'mine'") != std::string::npos);
    CHECK(setup.error().message.find("'shadows;'") != std::string::npos);
    CHECK(setup.error().file == "job.toml");
    CHECK(setup.error().line == 8);
    channels[1].expression = "C<RD";
    CHECK_FALSE(LpeSetup::build(channels, 0));
}

}  // namespace raylex::display
