// The compiler against the oracle: all small expressions on all small paths, and large random ones.
#include <catch2/catch.hpp>

#include <algorithm>

#include "lpe/match.h"
#include "lpe/program.h"
#include "oracle.h"

using namespace raylex::lpe;

namespace {

ChannelSource source_of(const std::string& text, Dialect dialect) {
    ChannelSource source;
    source.expression = text;
    source.dialect = dialect;
    return source;
}

State run(const Program& program, State state, const oracle::Path& path) {
    for (const Event& event : path) { state = program.next(state, program.classify(event)); }
    return state;
}

struct Tally {
    std::size_t expressions = 0, refused = 0, accepted_path_strings = 0, words = 0;
};

/// Compares every sequence of `length` tokens; the first difference fails the test with its text.
void compare_all(Dialect dialect, std::size_t length, const std::vector<oracle::Path>& paths, Tally& tally) {
    const std::size_t count = oracle::tokens(dialect).size();
    std::vector<std::size_t> sequence(length, 0);
    for (bool more = true; more;) {
        const std::string text = oracle::text_of(sequence, dialect);
        const auto tree = oracle::parse(sequence, dialect);
        const ChannelSource source = source_of(text, dialect);
        const auto program = Program::compile({&source, 1}, {.any_path_string = true});
        if (program.ok() != (tree != nullptr)) {
            FAIL("'" << text << "' is " << (tree ? "an expression but was refused" : "no expression but was accepted"));
        }
        ++(tree ? tally.expressions : tally.refused);
        for (const oracle::Path& path : tree ? paths : std::vector<oracle::Path>{}) {
            const bool found = program->accepts_any(run(*program, program->starts()[0], path));
            const bool expected = oracle::matches(*tree, path, dialect);
            ++tally.words;
            tally.accepted_path_strings += expected ? 1 : 0;
            if (found != expected) {
                FAIL("'" << text << "' on '" << to_text(path) << "': " << found << ", oracle " << expected);
            }
        }
        more = false;
        for (std::size_t i = length; i-- > 0 && !more;) {
            more = ++sequence[i] < count;
            if (!more) { sequence[i] = 0; }
        }
    }
}

/// Compares by sets of words; skips sequences that are not expressions, whose refusal compare_all() checks.
void compare_all_languages(Dialect dialect, std::size_t length, Tally& tally) {
    const oracle::ShortPathStrings universe(dialect, 5);
    const std::size_t count = oracle::tokens(dialect).size();
    std::vector<std::size_t> sequence(length, 0);
    std::vector<State> states(universe.words().size());
    std::vector<EventClass> classes(universe.events().size());
    for (bool more = true; more;) {
        if (const auto tree = oracle::parse(sequence, dialect)) {
            const std::string text = oracle::text_of(sequence, dialect);
            const ChannelSource source = source_of(text, dialect);
            const auto program = Program::compile({&source, 1}, {.any_path_string = true});
            if (!program) FAIL("'" << text << "' was refused: " << program.error().message);
            for (std::size_t k = 0; k < classes.size(); ++k) classes[k] = program->classify(universe.events()[k]);
            const auto language = universe.language(*tree);
            states[0] = program->starts()[0];
            for (std::size_t w = 0; w < states.size(); ++w) {
                if (w > 0) states[w] = program->next(states[universe.parent(w)], classes[universe.last_event(w)]);
                if (program->accepts_any(states[w]) != language[w]) {
                    FAIL("'" << text << "' on '" << to_text(universe.words()[w]) << "': oracle " << language[w]);
                }
            }
            ++tally.expressions;
            tally.words += states.size();
            tally.accepted_path_strings += language.count();
        }
        more = false;
        for (std::size_t i = length; i-- > 0 && !more;) {
            more = ++sequence[i] < count;
            if (!more) sequence[i] = 0;
        }
    }
}

void compare_random(Dialect dialect, std::uint64_t seed, int rounds) {
    oracle::Random random(seed);
    std::size_t accepted = 0;
    int spread = 0;
    for (int round = 0; round < rounds; ++round) {
        std::vector<ChannelSource> sources;
        std::vector<std::shared_ptr<oracle::Tree>> trees;
        for (int k = 0; k < 5; ++k) {
            const auto sequence = oracle::random_expression(random, dialect, 2 + random.below(9));
            sources.push_back(source_of(oracle::text_of(sequence, dialect), dialect));
            trees.push_back(oracle::parse(sequence, dialect));
            REQUIRE(trees.back() != nullptr);
        }
        // In every second round a small cap distributes the channels over groups, of which five are always enough.
        CompileOptions options{.group_cap = 5, .any_path_string = true};
        if (round % 2 == 1) options.state_cap = 8;
        const auto program = Program::compile(sources, options);
        INFO(sources[0].expression << "\n" << sources[1].expression << "\n" << sources[2].expression);
        REQUIRE(program);
        spread += program->starts().size() > 1 ? 1 : 0;
        for (int p = 0; p < 60; ++p) {
            const oracle::Path path = oracle::random_path(random, 7);
            std::vector<bool> found(trees.size(), false);
            for (const State start : program->starts()) {
                for (const std::uint16_t k : program->accepted(run(*program, start, path))) {
                    REQUIRE_FALSE(found[k]);
                    found[k] = true;
                }
            }
            for (std::size_t k = 0; k < trees.size(); ++k) {
                const bool expected = oracle::matches(*trees[k], path, dialect);
                accepted += expected ? 1 : 0;
                if (found[k] != expected) {
                    FAIL("'" << sources[k].expression << "' on '" << to_text(path) << "': " << found[k] << ", oracle "
                             << expected);
                }
            }
        }
    }
    // The comparison is meaningful only if both answers are frequent.
    REQUIRE(accepted > static_cast<std::size_t>(rounds) * 10);
    REQUIRE(spread > rounds / 4);
}

}  // namespace

TEST_CASE("every expression of up to three tokens agrees with the oracle on every short path",
          "[release-only][oracle][gate]") {
    for (const Dialect dialect : {Dialect::renderman, Dialect::osl}) {
        const auto paths = oracle::all_paths(dialect, 3);
        Tally tally;
        for (std::size_t length = 1; length <= 3; ++length) { compare_all(dialect, length, paths, tally); }
        CHECK(tally.expressions > 1000);
        CHECK(tally.refused > 1000);
        CHECK(tally.accepted_path_strings > 1000);
    }
}

TEST_CASE("the two oracles, by positions and by sets of words, agree", "[release-only][oracle]") {
    for (const Dialect dialect : {Dialect::renderman, Dialect::osl}) {
        const oracle::ShortPathStrings universe(dialect, 4);
        oracle::Random random(24);
        for (int round = 0; round < 60; ++round) {
            const auto sequence = oracle::random_expression(random, dialect, 2 + random.below(5));
            const auto tree = oracle::parse(sequence, dialect);
            REQUIRE(tree != nullptr);
            const auto language = universe.language(*tree);
            for (std::size_t w = 0; w < universe.words().size(); ++w) {
                if (language[w] != oracle::matches(*tree, universe.words()[w], dialect)) {
                    FAIL("'" << oracle::text_of(sequence, dialect) << "' on '" << to_text(universe.words()[w]) << "'");
                }
            }
        }
    }
}

TEST_CASE("every expression of four and of five tokens agrees with the oracle on every path of up to five events",
          "[.full][oracle]") {
    for (const Dialect dialect : {Dialect::renderman, Dialect::osl}) {
        Tally tally;
        compare_all_languages(dialect, 4, tally);
        compare_all_languages(dialect, 5, tally);
        WARN(tally.expressions << " expressions, " << tally.accepted_path_strings << " of " << tally.words
                               << " words accepted");
        CHECK(tally.expressions > 100'000);
        CHECK(tally.accepted_path_strings > 1'000'000);
    }
}

TEST_CASE("random renderman expressions compiled together agree with the oracle", "[oracle]") {
    compare_random(Dialect::renderman, 20, 150);
}

TEST_CASE("random osl expressions compiled together agree with the oracle", "[oracle]") {
    compare_random(Dialect::osl, 21, 150);
}

TEST_CASE("many random expressions agree with the oracle", "[.full][oracle]") {
    compare_random(Dialect::renderman, 22, 20'000);
    compare_random(Dialect::osl, 23, 20'000);
}
