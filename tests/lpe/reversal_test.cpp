// Light subpaths read from the light, compared with the same words read forward.
#include <catch2/catch.hpp>

#include <set>
#include <string>

#include "lpe/match.h"
#include "lpe/program.h"
#include "lpe/reversal.h"
#include "lpe/shipped.h"
#include "oracle.h"
#include "sources.h"

using namespace raylex::lpe;
using lpe_test::shipped;

namespace {

void add(std::vector<ChannelSource>& channels, Dialect dialect, const std::string& before, const std::string& after,
         int count) {
    for (int k = 0; k < count; ++k) {
        channels.push_back({.name = {}, .expression = before + "obj" + std::to_string(k) + after, .dialect = dialect});
    }
}

/// Any sequence of events, usually a word of W.
std::vector<Event> random_spelling(oracle::Random& random) {
    std::vector<Event> word;
    if (random.below(30) != 0) { word.push_back({EventType::camera, Scatter::none, 0, {}}); }
    for (std::size_t k = random.below(8); k > 0; --k) {
        Event event;
        event.type = random.below(3) != 0 ? EventType::reflection : EventType::transmission;
        event.scatter = static_cast<Scatter>(1 + random.below(event.type == EventType::transmission ? 4 : 3));
        event.labels = {"obj" + std::to_string(random.below(5)), ""};
        const std::size_t odd = random.below(40);
        if (odd < 4) {
            event = {EventType::volume, Scatter::none, 0, {}};
        } else if (odd == 4) {
            event = {EventType::user, Scatter::none, 1, {}};
        } else if (odd == 5) {
            event = {EventType::light, Scatter::none, 0, {}};
        }
        word.push_back(event);
    }
    if (random.below(10) != 0) {
        const EventType terminals[] = {EventType::light, EventType::background, EventType::emission};
        word.push_back({terminals[random.below(3)], Scatter::none, 0, {"obj" + std::to_string(random.below(3))}});
    }
    return word;
}

/// Joins every split of random words and compares with forward matching.
void check_connections(const std::vector<ChannelSource>& channels, const CompileOptions& options, bool has_parallel,
                       std::size_t least_words) {
    const auto program = Program::compile(channels, options);
    if (!program) { FAIL(program.error().to_string()); }
    REQUIRE(program->view().has_parallel() == has_parallel);
    REQUIRE(program->word_count() >= least_words);
    const auto reversed = ReversedProgram::build(*program);
    if (!reversed) { FAIL(reversed.error().to_string()); }
    oracle::Random random(77);
    std::size_t accepted = 0;
    for (int round = 0; round < 300; ++round) {
        const std::vector<Event> word = random_spelling(random);
        std::vector<EventClass> events;
        for (const Event& event : word) { events.push_back(program->classify(event)); }
        std::vector<std::vector<State>> camera{{program->starts().begin(), program->starts().end()}};
        for (const EventClass event : events) {
            camera.push_back(camera.back());
            program->advance(camera.back().data(), event, camera.back().data());
        }
        std::set<std::size_t> expected;
        program->for_each_accepted(camera.back().data(), [&](std::uint16_t k) { expected.insert(k); });
        accepted += expected.size();

        INFO(to_text(word));
        std::vector<State> light(reversed->starts().begin(), reversed->starts().end()), whole(program->word_count());
        bool alive = true;
        for (std::size_t split = word.size();; --split) {
            std::set<std::size_t> found;
            const bool joined = reversed->connect(camera[split].data(), light.data(), whole.data());
            program->for_each_accepted(whole.data(), [&](std::uint16_t k) { found.insert(k); });
            CAPTURE(split);
            REQUIRE(found == expected);
            REQUIRE((joined || expected.empty()));
            if (!has_parallel) REQUIRE(joined == !expected.empty());
            REQUIRE((alive || expected.empty()));  // Law 4: only what can never accept is dead
            if (split == 0) { break; }
            alive = reversed->prepend(light.data(), events[split - 1], light.data());
        }
    }
    CHECK(accepted > 50);
}

}  // namespace

TEST_CASE("light subpaths connected to camera subpaths match like whole words", "[reversal]") {
    for (const Dialect dialect : {Dialect::renderman, Dialect::osl}) {
        CAPTURE(dialect == Dialect::osl);
        std::vector<ChannelSource> channels = shipped(dialect);
        add(channels, dialect, "C<RD'", "'>[DS]*L", 5);
        add(channels, dialect, "CD*<L.'", "'>", 3);
        check_connections(channels, {}, false, 1);  // one table
        check_connections(channels, {.state_cap = 12, .group_cap = 20, .any_path_string = true}, false,
                          2);  // several tables
        std::vector<ChannelSource> packed = channels;
        add(packed, dialect, "C.*<RD'", "'>.*L", 40);
        check_connections(packed, {}, true, 3);  // a table and automata of one bit
        std::vector<ChannelSource> wide;
        add(wide, dialect, "C.*<RD'", "'>.*", 40);
        add(wide, dialect, "C.*<RG'obj1'>.*<RD'", "'>.*", 40);
        add(wide, dialect, "C.*<.D'", "'>.*D.[LO]", 40);
        check_connections(wide, {}, true, 4);  // wider automata
    }
}

TEST_CASE("a light subpath that no connection can complete is dead", "[reversal][law4]") {
    const ChannelSource channel{.name = "direct", .expression = "C<RD>[<L.'key'>]"};
    const auto program = Program::compile({&channel, 1});
    REQUIRE(program);
    const auto reversed = ReversedProgram::build(*program);
    REQUIRE(reversed);
    std::vector<State> light(reversed->starts().begin(), reversed->starts().end());
    const auto prepend = [&](const char* event) {
        return reversed->prepend(light.data(), program->classify(parse_events(event)->front()), light.data());
    };
    CHECK(prepend("L,-,key"));
    CHECK(prepend("R,D"));
    CHECK_FALSE(prepend("R,D"));
    CHECK_FALSE(prepend("C,-"));
    light.assign(reversed->starts().begin(), reversed->starts().end());
    CHECK_FALSE(prepend("L,-,fill"));
}

TEST_CASE("a reversal that would be too large is an error", "[reversal]") {
    const auto program = Program::compile(shipped(Dialect::renderman));
    REQUIRE(program);
    const auto refused = ReversedProgram::build(*program, {.state_cap = 3});
    REQUIRE_FALSE(refused);
    CHECK(refused.error().message.find("needs more than 3 states") != std::string::npos);
    CHECK_FALSE(ReversedProgram::build(*program, {.byte_cap = 100}));
    CHECK(ReversedProgram::build(*program));
}
