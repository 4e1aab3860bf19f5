// Channels that would multiply in a table become bit-parallel automata: they accept what each accepts alone.
#include <catch2/catch.hpp>

#include <algorithm>
#include <set>
#include <string>

#include "lpe/match.h"
#include "lpe/program.h"
#include "oracle.h"

using namespace raylex::lpe;

namespace {

std::string label(std::size_t k) {
    return "obj" + std::to_string(k);
}

/// Adds one channel for each of `count` labels; the label replaces every '@' of the expression.
void add_family(std::vector<ChannelSource>& channels, const std::string& expression, std::size_t count,
                Dialect dialect = Dialect::osl) {
    for (std::size_t k = 0; k < count; ++k) {
        ChannelSource channel{.name = expression + std::to_string(k), .expression = {}, .dialect = dialect};
        for (const char c : expression) { channel.expression += c == '@' ? label(k) : std::string(1, c); }
        channels.push_back(std::move(channel));
    }
}

/// A random sequence of events, usually a word of W, with few labels, so that they repeat.
std::vector<Event> labelled_path(oracle::Random& random, std::size_t labels) {
    std::vector<Event> word;
    if (random.below(20) != 0) { word.push_back({EventType::camera, Scatter::none, 0, {}}); }
    const std::size_t base = random.below(labels);
    for (std::size_t k = random.below(7); k > 0; --k) {
        Event event;
        event.type = random.below(3) != 0 ? EventType::reflection : EventType::transmission;
        event.scatter = static_cast<Scatter>(1 + random.below(event.type == EventType::transmission ? 4 : 3));
        event.labels = {random.below(5) == 0 ? "other" : label((base + random.below(3)) % labels), "lobe"};
        if (random.below(10) == 0) {
            event = {EventType::volume, Scatter::none, 0, {}};
        } else if (random.below(20) == 0) {
            event = {EventType::user, Scatter::none, static_cast<std::uint8_t>(1 + random.below(3)), {}};
        } else if (random.below(60) == 0) {
            event = {random.below(2) != 0 ? EventType::camera : EventType::light, Scatter::none, 0, {}};
        }
        word.push_back(event);
    }
    const EventType terminals[] = {EventType::light, EventType::background, EventType::emission};
    word.push_back(
        {terminals[random.below(3)], Scatter::none, 0, {random.below(3) != 0 ? label(random.below(8)) : "lamp"}});
    return word;
}

struct Followed {
    std::set<std::size_t> channels;
    bool alive = true;
};

Followed follow(const Program& program, const std::vector<Event>& path) {
    std::vector<State> words(program.starts().begin(), program.starts().end());
    Followed result;
    for (const Event& event : path) {
        result.alive = program.advance(words.data(), program.classify(event), words.data());
    }
    program.for_each_accepted(words.data(),
                              [&](std::uint16_t channel) { REQUIRE(result.channels.insert(channel).second); });
    CHECK(program.accepts_any_of(words.data()) == !result.channels.empty());
    return result;
}

void check_against_each_alone(const std::vector<ChannelSource>& channels, std::size_t labels, std::size_t least_matches,
                              bool dies_exactly) {
    const auto program = Program::compile(channels);
    if (!program) { FAIL(program.error().to_string()); }
    REQUIRE(program->view().has_parallel());
    std::vector<Program> alone;
    for (const ChannelSource& channel : channels) {
        auto one = Program::compile({&channel, 1});
        REQUIRE(one);
        alone.push_back(std::move(*one));
    }
    oracle::Random random(21);
    std::size_t matches = 0;
    for (int round = 0; round < 400; ++round) {
        const std::vector<Event> path = labelled_path(random, labels);
        Followed expected;
        expected.alive = false;
        for (std::size_t k = 0; k < alone.size(); ++k) {
            const Followed one = follow(alone[k], path);
            expected.alive = expected.alive || one.alive;
            if (!one.channels.empty()) { expected.channels.insert(k); }
        }
        INFO(to_text(path));
        const Followed found = follow(*program, path);
        REQUIRE(found.channels == expected.channels);
        REQUIRE((found.alive || !expected.alive));
        if (dies_exactly) { REQUIRE(found.alive == expected.alive); }
        matches += expected.channels.size();
    }
    CHECK(matches > least_matches);
}

}  // namespace

TEST_CASE("128 channels that each look for a label anywhere take five words", "[bit-parallel]") {
    std::vector<ChannelSource> channels;
    add_family(channels, "C.*<RD'@'>.*", 128);
    const auto program = Program::compile(channels);
    REQUIRE(program);
    CHECK(program->word_count() == 5);  // the phase, and one bit per channel
    CHECK(program->tables().bytes() < 32'000);
    check_against_each_alone(channels, 128, 100, true);
}

TEST_CASE("channels share tables and words of bits so that a path's state takes the fewest words", "[bit-parallel]") {
    const auto path_strings_of = [](const char* family, const char* other) {
        std::vector<ChannelSource> channels;
        add_family(channels, family, 24, Dialect::renderman);
        add_family(channels, other, 24, Dialect::renderman);
        const auto program = Program::compile(channels);
        REQUIRE(program);
        return program->word_count();
    };
    // A table whose states grow like a sum is one word. 48 labels anywhere take the phase and two words of bits.
    CHECK(path_strings_of("C<RD'@'>L", "C<RD'@'>[DSV]*L") == 1);
    CHECK(path_strings_of("C.*<RD'@'>L", "C.*<RD'@'>.*L") == 3);
    // Automata of three bits take the phase and three words, fewer than their tables; the others join them as bits.
    CHECK(path_strings_of("C.*<.D'@'>.*<..'@'>.[LO]", "C<RD'@'>[DSV]*L") == 4);
}

TEST_CASE("bit-parallel automata of every width, in both dialects, accept what each channel accepts alone",
          "[bit-parallel][gate]") {
    std::vector<ChannelSource> channels;
    SECTION("two labels in order, three codes") {
        add_family(channels, "C.*<RD'@'>.*<.G'@'>.*", 40);
    }
    SECTION("automata that die") {
        add_family(channels, "C[^'@']*L", 40);
    }
    SECTION("five codes") {
        add_family(channels, "C.*<.D'@'>.*<..'@'>.[LO]", 40);
    }
    SECTION("all widths at once") {
        add_family(channels, "C.*<RD'@'>.*", 40);
        add_family(channels, "C.*<RG'@'>.*<RD'@'>.*", 12);
        add_family(channels, "C.*<.D'@'>.*<..'@'>.[LO]", 10);
    }
    SECTION("a label anywhere, then a light") {
        add_family(channels, "C.*<RD'@'>.*L", 20);
        add_family(channels, "C.*<RD'@'>.*B", 20);
        add_family(channels, "C[^<RD'@'>]*L", 20, Dialect::renderman);  // the same bit, inverted
    }
    SECTION("renderman: pass-through events leave no event") {
        add_family(channels, "C.*<RD'@'>.*[<L.>O]", 40, Dialect::renderman);
    }
    SECTION("renderman: user events") {
        add_family(channels, "C.*<RD'@'>[.U1U2]*L", 40, Dialect::renderman);
    }
    SECTION("together with channels that test the first hit") {
        add_family(channels, "C.*<RD'@'>.*", 40);
        add_family(channels, "C<RD'@'>[DGS]*L", 20);
        add_family(channels, "C<RD'@'>[DGS]*B", 20);
        add_family(channels, "C<RS'@'>[DGSV]*L", 20);
    }
    check_against_each_alone(channels, 6, 10, false);
}

TEST_CASE("paths that no packed channel can accept any more are dead", "[bit-parallel][law4]") {
    std::vector<ChannelSource> channels;
    add_family(channels, "C[^'@']*L", 40);
    check_against_each_alone(channels, 2, 40, true);
    const auto program = Program::compile(channels);
    REQUIRE(program);
    // A diffuse event off obj0 leaves only obj0's channel alive; a terminal other than L ends all channels.
    std::vector<State> words(program->starts().begin(), program->starts().end());
    const auto move = [&](const char* event) {
        return program->advance(words.data(), program->classify(parse_events(event)->front()), words.data());
    };
    CHECK(move("C,-"));
    CHECK(move("R,D,obj0"));
    CHECK_FALSE(move("B,-"));
    CHECK_FALSE(program->accepts_any_of(words.data()));
    CHECK_FALSE(move("L,-"));
    words.assign(program->starts().begin(), program->starts().end());
    CHECK(move("C,-"));
    CHECK_FALSE(move("C,-"));
    CHECK_FALSE(move("R,D,obj0"));
}

TEST_CASE("many paths at once move and accept as one does", "[bit-parallel]") {
    std::vector<ChannelSource> channels;
    add_family(channels, "C.*<RD'@'>.*", 40);
    add_family(channels, "C<RD'@'>[DGS]*L", 10);
    std::vector<ChannelSource> few(channels.end() - 10, channels.end());
    for (const auto& list : {channels, few}) {
        const auto program = Program::compile(list);
        REQUIRE(program);
        const std::size_t paths = 50, words = program->word_count(), mask_words = program->mask_words();
        std::vector<std::vector<Event>> path(paths);
        std::vector<State> states;
        oracle::Random random(5);
        for (auto& each : path) {
            each = labelled_path(random, 10);
            each.resize(4, {EventType::light, Scatter::none, 0, {}});
            states.insert(states.end(), program->starts().begin(), program->starts().end());
        }
        for (std::size_t step = 0; step < 4; ++step) {
            std::vector<EventClass> events;
            for (const auto& each : path) { events.push_back(program->classify(each[step])); }
            program->advance(states, events);
        }
        std::vector<std::uint32_t> masks(paths * mask_words, 0xFFFFFFFFU);
        program->accepts(states, masks);
        for (std::size_t k = 0; k < paths; ++k) {
            std::set<std::size_t> found;
            for (std::size_t channel = 0; channel < list.size(); ++channel) {
                if ((masks[k * mask_words + channel / 32] >> channel % 32 & 1U) != 0) { found.insert(channel); }
            }
            REQUIRE(found == follow(*program, path[k]).channels);
        }
        REQUIRE(words == states.size() / paths);
    }
}
