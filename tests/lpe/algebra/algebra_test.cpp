// Coverage, equality, containment, emptiness, and combined languages, compared with enumeration by match().
#include <catch2/catch.hpp>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "lpe/algebra/proofs/paths.h"
#include "lpe/algebra/proofs/relations.h"
#include "lpe/match.h"
#include "tests/lpe/sources.h"

using namespace raylex::lpe;
using lpe_test::source;

namespace {

std::vector<ChannelSource> sources(const std::vector<std::string>& texts) {
    std::vector<ChannelSource> channels;
    for (const std::string& text : texts) { channels.push_back(source(text)); }
    return channels;
}

/// Words of W with at most `longest` events, without labels, lobe numbers and pass-through events.
std::vector<std::vector<Event>> short_path_strings(std::size_t longest) {
    std::vector<Event> scattering{{EventType::volume, Scatter::none, 0, {}}};
    for (const EventType type : {EventType::reflection, EventType::transmission}) {
        for (const Scatter scatter : {Scatter::diffuse, Scatter::glossy, Scatter::singular}) {
            scattering.push_back({type, scatter, 0, {}});
        }
    }
    std::vector<std::vector<Event>> prefixes{{Event{}}};
    std::vector<std::vector<Event>> words;
    for (std::size_t i = 0; i < prefixes.size(); ++i) {
        for (const EventType end : {EventType::light, EventType::background, EventType::emission}) {
            words.push_back(prefixes[i]);
            words.back().push_back({end, Scatter::none, 0, {}});
        }
        if (prefixes[i].size() + 1 < longest) {
            for (const Event& event : scattering) {
                std::vector<Event> next = prefixes[i];
                next.push_back(event);
                prefixes.push_back(std::move(next));
            }
        }
    }
    return words;
}

std::vector<bool> accepted(const ChannelSource& channel, const std::vector<std::vector<Event>>& words) {
    std::vector<bool> answers;
    for (const std::vector<Event>& word : words) {
        const auto answer = match(channel.expression, word, channel.dialect);
        REQUIRE(answer);
        answers.push_back(*answer);
    }
    return answers;
}

/// The length of the shortest word for which `wanted` is true; 0 for none.
std::size_t shortest_length(const std::vector<std::vector<Event>>& words, const std::vector<bool>& wanted) {
    std::size_t shortest = 0;
    for (std::size_t i = 0; i < words.size(); ++i) {
        if (wanted[i] && (shortest == 0 || words[i].size() < shortest)) { shortest = words[i].size(); }
    }
    return shortest;
}

// Without labels and lobe numbers, so that an enumeration over the plain letters is exhaustive.
const std::vector<std::string> expressions{"C.*",        "CD*L",         "C[DS]*[<L.>O]", "C<RD>.+",
                                           "C.*D.*S.*",  "C(D|SS)*B",    "!(C.*D.*)",     "C[^D]*L&C.S*.",
                                           "C<T.>?[LO]", "CV{1,2}[LBO]", "CLD",           "C.{2}O - CD.O",
                                           "osl:C.*",    "osl:C[GS]+L",  "osl:C<R[DG]>.*"};
constexpr std::size_t longest = 4;

}  // namespace

TEST_CASE("equality, containment and emptiness agree with enumeration, and their counterexamples are shortest",
          "[gate]") {
    const auto words = short_path_strings(longest);
    PathStrings without_straight;  // the enumeration has none
    without_straight.straight = false;
    std::vector<std::vector<bool>> sets;
    for (const std::string& text : expressions) { sets.push_back(accepted(source(text), words)); }
    for (std::size_t a = 0; a < expressions.size(); ++a) {
        CAPTURE(expressions[a]);
        const auto empty = check_empty(source(expressions[a]), without_straight);
        REQUIRE(empty);
        // Each of these with a path has one of at most four events.
        CHECK(empty->holds == (shortest_length(words, sets[a]) == 0));
        if (!empty->holds) { CHECK(empty->witness.events.size() == shortest_length(words, sets[a])); }
        for (std::size_t b = 0; b < expressions.size(); ++b) {
            CAPTURE(expressions[b]);
            std::vector<bool> only_b(words.size()), differ(words.size());
            for (std::size_t i = 0; i < words.size(); ++i) {
                only_b[i] = sets[b][i] && !sets[a][i];
                differ[i] = sets[b][i] != sets[a][i];
            }
            const auto contains = check_contains(source(expressions[a]), source(expressions[b]), without_straight);
            const auto equal = check_equal(sources({expressions[a], expressions[b]}), without_straight);
            REQUIRE(contains);
            REQUIRE(equal);
            for (const auto& [proof, against] : {std::pair{&*contains, &only_b}, std::pair{&*equal, &differ}}) {
                const std::size_t shortest = shortest_length(words, *against);
                if (shortest > 0) {
                    CHECK_FALSE(proof->holds);
                    CHECK(proof->witness.events.size() == shortest);
                }
                if (!proof->holds) {
                    const bool in_a = *match(source(expressions[a]).expression, proof->witness.events,
                                             source(expressions[a]).dialect);
                    const bool in_b = *match(source(expressions[b]).expression, proof->witness.events,
                                             source(expressions[b]).dialect);
                    CHECK(in_a != in_b);
                    CHECK((proof == &*equal || in_b));
                }
            }
        }
    }
}

TEST_CASE("complement, union, intersection and difference have the paths that enumeration finds, and the same counts",
          "[gate]") {
    const auto words = short_path_strings(longest);
    PathStrings without_straight;
    without_straight.straight = false;
    PathSetOptions options;
    options.longest_counted = longest;
    const auto check = [&](Operation operation, const std::vector<std::string>& texts,
                           const std::vector<bool>& wanted) {
        const auto paths = look_at_paths(operation, sources(texts), without_straight, options);
        REQUIRE(paths);
        std::vector<std::uint64_t> counts(longest + 1, 0);
        for (std::size_t i = 0; i < words.size(); ++i) { counts[words[i].size()] += wanted[i] ? 1 : 0; }
        CHECK(paths->counts == counts);
        std::set<std::string> seen;
        for (const Witness& sample : paths->samples) {
            CHECK(seen.insert(sample.text).second);
            CHECK(sample.events.size() >= paths->samples.front().events.size());
        }
    };
    for (const std::string& a : expressions) {
        CAPTURE(a);
        const std::vector<bool> in_a = accepted(source(a), words);
        std::vector<bool> wanted = in_a;
        check(Operation::words, {a}, wanted);
        wanted.flip();
        check(Operation::complement, {a}, wanted);
        for (const std::string& b : {expressions[2], expressions[4], expressions[13]}) {
            CAPTURE(b);
            const std::vector<bool> in_b = accepted(source(b), words);
            for (std::size_t i = 0; i < words.size(); ++i) wanted[i] = in_a[i] && in_b[i];
            check(Operation::intersection, {a, b}, wanted);
            for (std::size_t i = 0; i < words.size(); ++i) wanted[i] = in_a[i] || in_b[i];
            check(Operation::united, {a, b}, wanted);
            for (std::size_t i = 0; i < words.size(); ++i) wanted[i] = in_a[i] && !in_b[i];
            check(Operation::difference, {a, b}, wanted);
        }
    }
}

TEST_CASE("the samples of a set of paths belong to it") {
    for (const std::string text :
         {"C<RD'floor'>[DSV]+<L.'key*'>", "C(D2|S4)+<L.[^'key']>", "osl:C<RS[^'D']>.*B", "osl:C<Ts>*L"}) {
        CAPTURE(text);
        const auto paths = look_at_paths(Operation::words, sources({text}));
        REQUIRE(paths);
        REQUIRE(paths->samples.size() >= 2);
        for (const Witness& sample : paths->samples) {
            CAPTURE(sample.text);
            CHECK(*match(source(text).expression, sample.events, source(text).dialect));
            CHECK(to_text(*parse_events(sample.text)) == sample.text);
        }
    }
    const auto finite = look_at_paths(Operation::words, sources({"C.{1,3}L"}));
    REQUIRE(finite);
    CHECK(finite->longest == 5U);
    CHECK_FALSE(look_at_paths(Operation::words, sources({"C.*"}))->longest);
    CHECK(look_at_paths(Operation::difference, sources({"CDL", "C.*"}))->empty());
    // Counts beyond 64 bits are clamped, not wrapped.
    PathSetOptions many;
    many.longest_counted = 64;
    CHECK(look_at_paths(Operation::words, sources({"C.*"}), {}, many)->counts.back() == 1'000'000'000'000'000'000U);
}

TEST_CASE("every expression for the beauty is recognised as the beauty") {
    PathStrings no_medium;
    no_medium.volume = false;
    for (const std::string text : {"C.*", "C.*[LOB]", "C.+", "lpe:C.*", "C[DSV]*[<L.>O]", "C.*L|O|B"}) {
        const auto beauty = is_beauty(source(text));
        CAPTURE(text);
        REQUIRE(beauty);
        CHECK(*beauty);
    }
    CHECK(*is_beauty(source("osl:C.*")));
    CHECK(*is_beauty(source("osl:C[DGSsV]*[LOB]")));
    CHECK_FALSE(*is_beauty(source("osl:C[DGSV]*[LOB]")));  // Ts is missing
    CHECK_FALSE(*is_beauty(source("C[DS]*[<L.>O]")));
    CHECK(*is_beauty(source("C[DS]*[<L.>O]"), no_medium));
    CHECK_FALSE(*is_beauty(source("C[DS]*L"), no_medium));
    PathStrings no_emission = no_medium;
    no_emission.emission = false;
    CHECK(*is_beauty(source("C[DS]*L"), no_emission));
    PathStrings shallow;
    shallow.max_depth = 2;
    CHECK(*is_beauty(source("C.{1,3}"), shallow));
    CHECK_FALSE(*is_beauty(source("C.{1,3}")));
    // A prefix changes the splatted value, so such a channel is not the beauty.
    CHECK_FALSE(*is_beauty(source("unoccluded;C.*")));
    CHECK_FALSE(is_beauty(source("C(")));
}

TEST_CASE("the summary of a partition mentions that its expression is the beauty") {
    std::vector<ChannelSource> channels = sources({"CL", "!CL"});
    channels[0].name = "a";
    channels[1].name = "b";
    const auto report = check_partition(channels, source("C.*[LOB]"));
    REQUIRE(report);
    CHECK(report->result == SplitProof::partition);
    CHECK(report->summary.find("the beauty") != std::string::npos);
}

TEST_CASE("coverage permits paths that are counted twice, but no missed paths") {
    CHECK(check_covers(sources({"C[DSV]*L", "C.*O", "C.*L"}))->holds);
    const auto missed = check_covers(sources({"CL", "C.+L"}));
    REQUIRE(missed);
    CHECK_FALSE(missed->holds);
    CHECK(missed->summary.find("no channel counts") != std::string::npos);
    CHECK(missed->witness.text == "C,- O,-");
    CHECK(check_covers(sources({"CL", "C.+L"}), source("C.*L"))->holds);
    // Channels with prefixes are refused, as in partitions.
    CHECK_FALSE(check_covers(sources({"noclamp;C.*"})));
}

TEST_CASE("proofs can mix dialects, and identify each expression") {
    const auto equal = check_equal(sources({"C<RD>L", "osl:C<RD>[LB]"}));
    REQUIRE(equal);
    // renderman words have no pass-through events, so the osl channel misses paths through a cutout.
    CHECK_FALSE(equal->holds);
    CHECK(equal->summary.find("osl:") != std::string::npos);
    PathStrings no_cutouts;
    no_cutouts.straight = false;
    CHECK(check_equal(sources({"C<RD>L", "osl:C<RD>[LB]"}), no_cutouts)->holds);
    const auto prefixes = check_equal(sources({"noclamp;CL", "CL"}));
    CHECK(prefixes->holds);
    CHECK(prefixes->warnings.size() == 1);
}

TEST_CASE("hostile expressions are errors that name the exceeded limit", "[gate]") {
    const std::string doubling = "C.*D.{24}L";
    for (const auto& failed :
         {check_empty(source(doubling)).ok(), check_equal(sources({doubling, "C.*"})).ok(),
          look_at_paths(Operation::complement, sources({doubling})).ok(), is_beauty(source(doubling)).ok()}) {
        CHECK_FALSE(failed);
    }
    CHECK_FALSE(look_at_paths(Operation::words, sources({"CL", "CDL"})));
    CHECK_FALSE(look_at_paths(Operation::united, {}));
}
