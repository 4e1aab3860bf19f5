// Programs of many channels: size, groups, the rest layer, limits.
#include <catch2/catch.hpp>

#include <algorithm>
#include <fstream>
#include <set>

#include "lpe/match.h"
#include "lpe/program.h"
#include "lpe/shipped.h"
#include "oracle.h"
#include "tests/support/paths.h"

using namespace raylex::lpe;

namespace {

std::vector<ChannelSource> read_set(const std::string& name) {
    std::ifstream file(raylex::test::source_dir() + "/lpe/bench/data/" + name);
    std::vector<ChannelSource> channels;
    for (std::string line; std::getline(file, line);) {
        if (!line.empty()) {
            ChannelSource channel;
            channel.name = channel.expression = line;
            channel.dialect = Dialect::osl;
            channels.push_back(channel);
        }
    }
    return channels;
}

std::set<std::size_t> accepted_by(const Program& program, const std::vector<Event>& path) {
    std::vector<State> words(program.starts().begin(), program.starts().end());
    bool alive = true;
    for (const Event& event : path) {
        const bool moved = program.advance(words.data(), program.classify(event), words.data());
        REQUIRE((alive || !moved));  // a dead path stays dead
        alive = moved;
    }
    std::set<std::size_t> channels;
    program.for_each_accepted(words.data(), [&](std::uint16_t channel) {
        REQUIRE(channels.insert(channel).second);  // no channel is in two groups
    });
    REQUIRE(program.accepts_any_of(words.data()) == !channels.empty());
    REQUIRE((alive || channels.empty()));
    return channels;
}

/// A random word of W over the labels of the benchmark sets.
std::vector<Event> random_path_string(oracle::Random& random) {
    const char* objects[] = {"floor", "wall", "hero", "glass", "skin", "thing", ""};
    const char* lights[] = {"key", "fill", "rim", "env", "lamp", ""};
    std::vector<Event> word{{EventType::camera, Scatter::none, 0, {}}};
    for (std::size_t k = random.below(5); k > 0; --k) {
        Event event;
        event.type = random.below(2) != 0 ? EventType::reflection : EventType::transmission;
        event.scatter = static_cast<Scatter>(1 + random.below(event.type == EventType::transmission ? 4 : 3));
        if (random.below(8) == 0) { event = {EventType::volume, Scatter::none, 0, {}}; }
        event.labels = {objects[random.below(7)], "lobe"};
        word.push_back(event);
    }
    const EventType terminals[] = {EventType::light, EventType::background, EventType::emission};
    word.push_back({terminals[random.below(3)], Scatter::none, 0, {lights[random.below(6)]}});
    return word;
}

}  // namespace

TEST_CASE("realistic channels compile to one small automaton", "[program]") {
    const auto channels = read_set("lpe_bench_firsthit.txt");
    REQUIRE(channels.size() == 128);
    const auto program = Program::compile(channels);
    REQUIRE(program);
    CHECK(program->group_count() == 1);
    // A generic symbol automaton, minimised, has 3427 states for this set (measured by its authors). Words that no
    // renderer reports are excluded here, so there can be fewer states but not more.
    CHECK(program->state_count() <= 3427);
    CHECK(program->class_count() <= 67);
}

TEST_CASE("channels that multiply are distributed over groups, and small ones are packed", "[program]") {
    const auto channels = read_set("lpe_bench_anywhere.txt");
    const auto program = Program::compile(channels);
    REQUIRE(program);
    CHECK(program->word_count() > 1);
    CHECK(program->word_count() <= CompileOptions{}.group_cap);
    CompileOptions tight;
    tight.state_cap = 100;
    tight.group_cap = 64;
    const auto spread = Program::compile(channels, tight);
    REQUIRE(spread);
    CHECK(spread->view().has_parallel());
    CHECK(spread->word_count() > program->word_count());
    tight.state_cap = 300;
    tight.group_cap = 2;
    tight.any_path_string = true;  // then nothing is packed
    const auto refused = Program::compile(channels, tight);
    REQUIRE_FALSE(refused);
    CHECK(refused.error().message.find("2 are allowed") != std::string::npos);
    tight = {};
    tight.state_cap = 100;
    tight.group_cap = 64;
    tight.word_cap = 3;
    const auto too_many_words = Program::compile(channels, tight);
    REQUIRE_FALSE(too_many_words);
    CHECK(too_many_words.error().message.find("3 are allowed") != std::string::npos);
}

TEST_CASE("channels compiled together accept the same paths as separately, in one group or in many",
          "[program][gate]") {
    for (const char* set : {"lpe_bench_firsthit.txt", "lpe_bench_anywhere.txt"}) {
        const auto channels = read_set(set);
        CompileOptions tight;
        tight.state_cap = 100;
        tight.group_cap = 64;
        const auto whole = Program::compile(channels);
        const auto spread = Program::compile(channels, tight);
        REQUIRE(whole);
        REQUIRE(spread);
        std::vector<Program> alone;
        for (const ChannelSource& channel : channels) {
            auto program = Program::compile({&channel, 1}, {.any_path_string = true});
            REQUIRE(program);
            alone.push_back(std::move(*program));
        }
        oracle::Random random(7);
        std::size_t matches = 0;
        for (int round = 0; round < 300; ++round) {
            const auto word = random_path_string(random);
            std::set<std::size_t> expected;
            for (std::size_t k = 0; k < alone.size(); ++k) {
                if (!accepted_by(alone[k], word).empty()) { expected.insert(k); }
            }
            INFO(to_text(word));
            REQUIRE(accepted_by(*whole, word) == expected);
            REQUIRE(accepted_by(*spread, word) == expected);
            matches += expected.size();
        }
        CHECK(matches > 300);
    }
}

TEST_CASE("the rest layer counts every path of the beauty that its channels do not count", "[program][law1]") {
    std::vector<ChannelSource> channels(3);
    channels[0] = {.name = "caustics", .expression = "CDS+L"};
    channels[1] = {.name = "floor", .expression = "C<RD'floor'>[^S]*L", .dialect = Dialect::osl};
    channels[2] = {.name = "rest"};
    channels[2].rest_of = {0, 1};
    const auto program = Program::compile(channels);
    REQUIRE(program);
    oracle::Random random(11);
    std::size_t rest = 0;
    for (int round = 0; round < 2000; ++round) {
        const auto word = random_path_string(random);
        const auto found = accepted_by(*program, word);
        INFO(to_text(word));
        REQUIRE(found.count(2) == (found.count(0) + found.count(1) == 0 ? 1U : 0U));
        rest += found.count(2);
    }
    CHECK(rest > 100);
    CHECK(rest < 2000);
    // A label that OSL's wildcards refuse must not lose light.
    const auto odd = parse_events("C,- R,D,floor,D L,-");
    REQUIRE(odd);
    CHECK(accepted_by(*program, *odd) == std::set<std::size_t>{2});

    channels[2].rest_of = {0, 7};
    CHECK_FALSE(Program::compile(channels));
}

TEST_CASE("states from which nothing can be accepted are dead", "[program][law4]") {
    const ChannelSource channel{.name = "direct", .expression = "C<RD>L"};
    const auto program = Program::compile({&channel, 1});
    REQUIRE(program);
    const auto step = [&](State state, const char* event) {
        return program->next(state, program->classify(parse_events(event)->front()));
    };
    const State camera = step(program->starts()[0], "C,-");
    const State diffuse = step(camera, "R,D,floor");
    CHECK(camera != Program::dead);
    CHECK(diffuse != Program::dead);
    CHECK(program->accepts_any(step(diffuse, "L,-,key")));
    CHECK(step(camera, "R,S") == Program::dead);
    CHECK(step(camera, "L,-") == Program::dead);
    CHECK(step(diffuse, "R,D") == Program::dead);
    CHECK(step(diffuse, "T,s") == diffuse);
    CHECK(step(step(diffuse, "L,-"), "R,D") == Program::dead);
    CHECK_FALSE(program->accepts_any(Program::dead));
    CHECK(step(Program::dead, "C,-") == Program::dead);
}

TEST_CASE("a program without channels, and one that can never match, are empty but valid", "[program]") {
    const Program none;
    CHECK(none.group_count() == 0);
    CHECK(none.classify({}) == 0);
    CHECK(none.next(Program::dead, 0) == Program::dead);
    const auto compiled = Program::compile({});
    REQUIRE(compiled);
    CHECK(compiled->state_count() == 1);
    const ChannelSource never{.name = "never", .expression = "CD&CS"};
    const auto program = Program::compile({&never, 1});
    REQUIRE(program);
    CHECK(program->starts()[0] == Program::dead);
}

TEST_CASE("equal languages give equal tables", "[program]") {
    // The minimal automaton is unique and has a canonical numbering, so different texts give the same tables.
    const auto tables = [](const char* expression) {
        ChannelSource source{.name = {}, .expression = expression};
        const auto program = Program::compile({&source, 1}, {.any_path_string = true});
        REQUIRE(program);
        std::vector<std::size_t> numbers{program->state_count(), program->starts()[0]};
        for (State state = 0; state < program->state_count(); ++state) {
            for (const Event& event : oracle::alphabet()) {
                numbers.push_back(program->next(state, program->classify(event)));
            }
            numbers.push_back(program->accepted(state).size());
        }
        return numbers;
    };
    CHECK(tables("CD*L") == tables("C(D+)?L"));
    CHECK(tables("C(D|S)*L") == tables("C(D*S*)*L"));
    CHECK(tables("C.*L") == tables("!(!(C.*L))"));
    CHECK(tables("C[DS]{2,4}L") == tables("C[DS][DS][DS]?[DS]?L"));
    CHECK(tables("CD*L") != tables("CD+L"));
}
