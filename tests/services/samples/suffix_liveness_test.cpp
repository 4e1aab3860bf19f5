// What channels can still take of a light subpath, by its path suffix and by the events that the scene can bring.
#include "display/services/liveness/suffix_liveness.h"

#include <array>

#include <catch2/catch.hpp>

#include "tests/services/lpe_helpers.h"

namespace raylex::display {
namespace {

using lpe::EventClass;
using test::build_setup;
using test::Classes;
using test::expression_channel;

struct Language {
    explicit Language(std::vector<ChannelDefinition> asked, const lpe::CompileOptions& options = {})
        : channels(std::move(asked)),
          setup(build_setup(channels, invalid_channel, options)),
          classes(setup),
          reversed(std::move(*lpe::ReversedProgram::build(setup.program()))),
          words(&reversed),
          table(channels, 1),
          services(setup, table, 1) {
        table.begin(test::pixel_rows(0, 0, 0, 1));
    }
    [[nodiscard]] SuffixLiveness liveness(const Liveness::Alphabet& alphabet) const {
        return {setup, &reversed, alphabet};
    }
    /// Whether a channel accepts the camera's events followed by the suffix.
    [[nodiscard]] bool takes(const std::vector<EventClass>& of_camera, const PathSuffix& word) {
        Tracker tracker = services.begin(0);
        for (const EventClass event : of_camera) services.move(tracker, event);
        services.connect(tracker, words, word);
        return services.channels_follow(tracker);
    }
    std::vector<ChannelDefinition> channels;
    LpeSetup setup;
    Classes classes;
    lpe::ReversedProgram reversed;
    PathSuffixes words;
    SampleTable table;
    LpeServices services;
};

/// Every sequence of so many of these events.
std::vector<std::vector<EventClass>> sequences(const std::vector<EventClass>& events, int length) {
    std::vector<std::vector<EventClass>> all{{}};
    for (int i = 0; i < length; ++i) {
        std::vector<std::vector<EventClass>> longer;
        for (const std::vector<EventClass>& each : all)
            for (const EventClass event : events) {
                longer.push_back(each);
                longer.back().push_back(event);
            }
        all = std::move(longer);
    }
    return all;
}

/// All words of at most 3 scatterings behind the join and 4 before it: the expressions' automata have so few states
/// that what these do not lead to, none do.
void check_against_all_path_strings(Language& language) {
    const Classes& c = language.classes;
    const std::vector<EventClass> events{c.diffuse, c.singular};
    const SuffixLiveness liveness = language.liveness({events, {}, {c.light, c.background}, {}, 0, {c.diffuse}});
    const auto check = [&](const PathSuffix& word) {
        const SuffixLiveness::LiveSet live = liveness.of(language.words, word);
        REQUIRE(live.seen == language.takes({}, word));
        bool connects = false, goes_on = false;
        for (int more = 1; more <= 4; ++more)
            for (const std::vector<EventClass>& of_camera : sequences(events, more)) {
                if (!language.takes(of_camera, word)) continue;
                connects = connects || of_camera.back() == c.diffuse;
                // A vertex that the camera sees, or two neighbours that can be joined.
                bool meets = of_camera.front() == c.diffuse;
                for (std::size_t i = 1; i < of_camera.size(); ++i)
                    meets = meets || (of_camera[i - 1] == c.diffuse && of_camera[i] == c.diffuse);
                goes_on = goes_on || meets;
            }
        REQUIRE(live.connects == connects);
        REQUIRE(live.goes_on == goes_on);
        for (const std::vector<EventClass>& of_camera : sequences(events, 2)) {
            Tracker tracker = language.services.begin(0);
            language.services.move(tracker, of_camera[0]);
            for (const EventClass there : events)
                REQUIRE(liveness.connects(tracker, std::array{of_camera[1]}, language.words, word, std::array{there}) ==
                        language.takes({of_camera[0], of_camera[1], there}, word));
        }
    };
    for (const EventClass terminal : {c.light, c.background})
        for (int length = 0; length <= 3; ++length)
            for (const std::vector<EventClass>& scatterings : sequences(events, length)) {
                PathSuffix word = language.services.begin(language.words, terminal);
                for (const EventClass event : scatterings)
                    word = language.services.prepend(language.words, word, event);
                check(word);
            }
}

}  // namespace

TEST_CASE("the suffix of a light subpath determines what is live", "[liveness][law4]") {
    Language language({expression_channel("direct", "C<RD>L"), expression_channel("caustic", "C<RD><RS>+L")});
    const Classes& c = language.classes;
    const SuffixLiveness liveness = language.liveness({{c.diffuse, c.singular}, {}, {c.light}, {}, 0, {c.diffuse}});
    CHECK(liveness.of(c.light).goes_on);
    CHECK(liveness.of(c.light).connects);  // light samples are joins with the light itself
    CHECK_FALSE(liveness.of(c.light).seen);
    CHECK_FALSE(liveness.of(c.emission).anything());
    const PathSuffix light = language.services.begin(language.words, c.light);
    SuffixLiveness::LiveSet live = liveness.after(language.words, light, std::array{c.diffuse}, 1);
    CHECK(live.seen);  // direct light, which nothing may come before
    CHECK_FALSE(live.connects);
    CHECK_FALSE(live.goes_on);
    live = liveness.after(language.words, light, std::array{c.singular}, 0);
    CHECK_FALSE(live.seen);
    CHECK_FALSE(live.connects);  // it has no density
    CHECK(live.goes_on);
    CHECK_FALSE(liveness.after(language.words, light, std::array{c.diffuse_through}, 1).anything());
    const PathSuffix mirrored = language.services.prepend(language.words, light, c.singular);
    live = liveness.after(language.words, mirrored, std::array{c.diffuse, c.singular}, 1);
    CHECK(live.seen);
    CHECK(live.goes_on);
    // Events that the scene does not bring keep nothing live.
    CHECK_FALSE(language.liveness({{c.singular}, {}, {c.light}, {}, 0, {}}).of(c.light).anything());
    CHECK(SuffixLiveness().of(c.emission).anything());  // nothing is known
}

TEST_CASE("liveness of path suffixes agrees with all path strings", "[liveness][law4]") {
    for (const char* expression : {"C<RD>L", "C<RD><RS>+L", "C<.S>*<RD>{2}L", "C[DS]*<RD><RS>L", "C.*<RS>L", "CL",
                                   "C<RD>(<RS><RD>)*L", "C<RS>.*B"}) {
        CAPTURE(expression);
        Language language({expression_channel("asked", expression)});
        check_against_all_path_strings(language);
    }
    const auto three = [](std::size_t state_cap) {
        lpe::CompileOptions options;
        options.state_cap = state_cap;
        return Language({expression_channel("caustic", "C<RD><RS>+L"), expression_channel("second", "C.*<RD><RD>L"),
                         expression_channel("sky", "C<RS>.*B")},
                        options);
    };
    Language in_groups = three(10);
    REQUIRE(in_groups.setup.program().word_count() > 1);
    REQUIRE_FALSE(in_groups.setup.program().view().has_parallel());
    check_against_all_path_strings(in_groups);
    // For bit-parallel channels nothing is known.
    Language in_bits = three(6);
    REQUIRE(in_bits.setup.program().view().has_parallel());
    const Classes& c = in_bits.classes;
    CHECK(in_bits.liveness({{c.singular}, {}, {c.light}, {}, 0, {}}).of(c.emission).anything());
}

TEST_CASE("no light subpath begins for path strings that only a camera subpath can find", "[liveness][law4]") {
    const auto begun = [](const char* expression) {
        const Language language({expression_channel("asked", expression)});
        const Classes& c = language.classes;
        return language.liveness({{c.diffuse, c.singular}, {}, {c.light}, {}, 0, {c.diffuse}}).of(c.light).goes_on;
    };
    CHECK_FALSE(begun("CL"));
    CHECK_FALSE(begun("C<RS>+L"));
    CHECK_FALSE(begun("C<RS><RD>L"));      // a light sample's
    CHECK_FALSE(begun("C<RS><RD><RS>L"));  // no two neighbours have a density, and the camera sees no such vertex
    CHECK(begun("C<RS><RD><RD><RS>L"));
    CHECK(begun("C<RD><RS>L"));
    CHECK(begun("C[DS]*L"));
}

TEST_CASE("cutouts before the camera and between joined vertices keep channels live", "[liveness][law4]") {
    ChannelDefinition behind = expression_channel("behind", "C<T[s]><RD>L");
    behind.dialect = lpe::Dialect::osl;
    Language language({behind});
    const Classes& c = language.classes;
    const EventClass straight =
        language.setup.classify({lpe::EventType::transmission, lpe::Scatter::straight, 0, {"", ""}});
    const PathSuffix light = language.services.begin(language.words, c.light);
    const auto live = [&](const Liveness::Alphabet& alphabet) {
        return language.liveness(alphabet).after(language.words, light, std::array{c.diffuse}, 1);
    };
    const SuffixLiveness::LiveSet passing = live({{c.diffuse}, {straight}, {c.light}, {}, 0, {c.diffuse}});
    CHECK(passing.seen);
    CHECK_FALSE(passing.connects);
    CHECK_FALSE(passing.goes_on);
    CHECK_FALSE(live({{c.diffuse}, {}, {c.light}, {}, 0, {c.diffuse}}).anything());
    const Tracker tracker = language.services.begin(0);
    CHECK(language.liveness({{c.diffuse}, {straight}, {c.light}, {}, 0, {c.diffuse}})
              .connects(tracker, std::array{c.diffuse}, language.words, light, std::array{c.diffuse}));
}

}  // namespace raylex::display
