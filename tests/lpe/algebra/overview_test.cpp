// The overview of channels that are not a partition; restricted words; texts for RenderMan's own parser.
#include <catch2/catch.hpp>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "lpe/algebra/proofs/overview.h"
#include "lpe/algebra/proofs/sorting.h"
#include "lpe/algebra/wording/regex_printing.h"
#include "lpe/language/extensions.h"
#include "lpe/match.h"
#include "tests/lpe/sources.h"

using namespace raylex;
using namespace raylex::lpe;
using lpe_test::channels_of;

namespace {

PathStrings surfaces() {
    PathStrings words;
    words.volume = false;
    return words;
}

bool matches_path(const std::string& expression, const std::string& events, Dialect dialect = Dialect::osl) {
    const auto path = parse_events(events);
    REQUIRE(path);
    const auto found = match(expression, *path, dialect);
    INFO(expression << " on " << events << (found ? "" : ": " + found.error().message));
    REQUIRE(found);
    return *found;
}

}  // namespace

TEST_CASE("the overview names every pair that overlaps, with the shortest path of each", "[overview]") {
    const auto channels = channels_of({{"direct", "C<RD>[<L.>O]"},
                                       {"diffuse", "CD[DS]*[<L.>O]"},
                                       {"specular", "CS[DS]*[<L.>O]"},
                                       {"seen", "C[<L.>O]"},
                                       {"key", "C[DS]*<L.'key'>"}});
    const auto found = look_over(channels, std::nullopt, surfaces());
    REQUIRE(found);
    std::vector<std::string> lines;
    for (const SharedPath& each : found->overlaps) {
        lines.push_back(channels[each.first].name + "+" + channels[each.second].name + " " + each.witness.text);
    }
    CHECK(lines == std::vector<std::string>{"direct+diffuse C,- R,D L,-", "direct+key C,- R,D L,-,key",
                                            "diffuse+key C,- R,D L,-,key", "specular+key C,- R,G L,-,key",
                                            "seen+key C,- L,-,key"});
    CHECK(found->holes.empty());
    CHECK(found->outside.empty());
    CHECK(found->empty.empty());
    CHECK(found->pairs_left == 0);
    // For each pair, a check of only these two channels gives the same answer.
    for (const SharedPath& each : found->overlaps) {
        const std::vector<ChannelSource> pair{channels[each.first], channels[each.second]};
        const auto report = check_disjoint(pair, surfaces());
        REQUIRE(report);
        CHECK(report->witness.text == each.witness.text);
    }
}

TEST_CASE("the overview lists every kind of missed path", "[overview]") {
    const auto found = look_over(channels_of({{"diffuse", "C<RD>.*"}, {"light", "C<L.>"}, {"never", "CLD"}}));
    REQUIRE(found);
    std::vector<std::string> lines;
    for (const Hole& hole : found->holes) {
        lines.push_back(hole.kind + ": " + hole.witness.text + " +" + std::to_string(hole.others.size()));
    }
    CHECK(lines.size() == 5);
    const auto has = [&](const std::string& line) {
        return std::find(lines.begin(), lines.end(), line) != lines.end();
    };
    INFO(Catch::StringMaker<std::vector<std::string>>::convert(lines));
    CHECK(has("seen directly: C,- O,- +0"));
    CHECK(has("first a specular reflection: C,- R,G L,- +2"));
    CHECK(has("first a diffuse transmission: C,- T,D L,- +2"));
    CHECK(has("first a specular transmission: C,- T,G L,- +2"));
    CHECK(has("first a scattering in a medium: C,- V,- L,- +2"));
    CHECK(found->empty == std::vector<std::size_t>{2});
}

TEST_CASE("paths outside the split expression are listed for each channel", "[overview]") {
    ChannelSource of;
    of.expression = "CD[DS]*[<L.>O]";
    const auto found = look_over(channels_of({{"all", "C[DS]*L"}, {"emission", "CD[DS]*O"}}), of, surfaces());
    REQUIRE(found);
    REQUIRE(found->outside.size() == 1);
    CHECK(found->outside[0].channel == 0);
    CHECK(found->outside[0].witness.text == "C,- L,-");
    CHECK(found->holes.empty());
}

TEST_CASE("an overview of five hundred channels works, with all or no overlaps", "[overview][release-only][gate]") {
    for (const bool overlap : {false, true}) {
        std::vector<std::pair<std::string, std::string>> list;
        for (int group = 0; group < 125; ++group) {
            for (const char* lobe : {"<RD>", "<RS>", "<TD>", "<TS>"}) {
                const std::string name = "g" + std::to_string(group);
                list.emplace_back(name + lobe, "C" + std::string(lobe) + (overlap ? ".*L" : ".*<L.'" + name + "'>"));
            }
        }
        const auto found = look_over(channels_of(list));
        REQUIRE(found);
        CHECK(found->overlaps.size() + found->pairs_left == (overlap ? 4U * (125U * 124U / 2U) : 0U));
    }
}

TEST_CASE("known light groups and labels restrict the words", "[words]") {
    PathStrings words;
    words.volume = false;
    words.light_groups = {"key", "fill"};
    words.unlabelled_lights = false;
    const auto split = channels_of({{"key", "C[DS]*<L.'key'>"}, {"fill", "C[DS]*<L.'fill'>"}, {"glow", "C[DS]*O"}});
    const auto report = check_partition(split, std::nullopt, words);
    REQUIRE(report);
    CHECK(report->result == SplitProof::partition);
    words.unlabelled_lights = true;
    const auto unlabelled = check_partition(split, std::nullopt, words);
    REQUIRE(unlabelled);
    CHECK(unlabelled->witness.text == "C,- L,-");
    words.light_groups = {"key", "fill", "rim"};
    words.unlabelled_lights = false;
    const auto rim = check_partition(split, std::nullopt, words);
    REQUIRE(rim);
    CHECK(rim->witness.text == "C,- L,-,rim");

    PathStrings objects;
    objects.object_labels = {"floor"};
    const auto by_object =
        channels_of({{"floor", "C<[RTV].'floor'>.*"}, {"plain", "C<[RTV].''>.*"}, {"seen", "C[LO]"}});
    const auto floors = check_partition(by_object, std::nullopt, objects);
    REQUIRE(floors);
    CHECK(floors->result == SplitProof::partition);
    const auto anything = check_partition(by_object);
    REQUIRE(anything);
    CHECK(anything->result == SplitProof::missed);
}

TEST_CASE("channels of several splits are sorted into them", "[sorting]") {
    const auto channels = channels_of({{"diffuse", "CD[DS]*[LO]"},
                                       {"key", "C[DS]*<L.'key'>"},
                                       {"specular", "CS[DS]*[LO]"},
                                       {"caustics", "CDS+L"},
                                       {"others", "C[DS]*[<L.[^'key']>O]"},
                                       {"seen", "C[LO]"}});
    const auto sorting = sort_into_partitions(channels, std::nullopt, surfaces());
    REQUIRE(sorting);
    CHECK(sorting->partitions == std::vector<std::vector<std::size_t>>{{0, 2, 5}, {1, 4}});
    CHECK(sorting->left == std::vector<std::size_t>{3});
    for (const auto& partition : sorting->partitions) {
        std::vector<ChannelSource> members;
        for (const std::size_t channel : partition) { members.push_back(channels[channel]); }
        const auto report = check_partition(members, std::nullopt, surfaces());
        REQUIRE(report);
        CHECK(report->result == SplitProof::partition);
    }
    const auto none = sort_into_partitions(channels);  // with media no split is complete
    REQUIRE(none);
    CHECK(none->partitions.empty());
}

TEST_CASE("a rest for RenderMan has only RenderMan's own syntax", "[rest]") {
    const std::vector<std::vector<std::pair<std::string, std::string>>> sets{
        {{"diffuse", "C<RD>.*"}},
        {{"seen", "C[<L.>O]"}, {"direct", "C<RD>[<L.>O]"}},
        {{"key", "C.*<L.'key'>"}, {"fill", "C.*<L.'fill'>"}},
        {{"coat", "C<RS4>.*"}, {"floor", "CD'floor'.*"}},
    };
    for (const auto& set : sets) {
        const auto channels = channels_of(set);
        const auto text = rest_expression(channels, std::nullopt, surfaces(), Reader::renderman);
        INFO(set.front().first);
        REQUIRE(text);
        REQUIRE(text->has_value());
        INFO(**text);
        CHECK(extensions_in(**text).empty());
        auto whole = channels;
        whole.push_back(channels_of({{"rest", **text}}).front());
        const auto proof = check_partition(whole, std::nullopt, surfaces());
        REQUIRE(proof);
        CHECK(proof->result == SplitProof::partition);
    }
    // RenderMan's syntax cannot express V.
    const auto volume = rest_expression(channels_of({{"surfaces", "C[DS]*[LO]"}}), std::nullopt, {}, Reader::renderman);
    REQUIRE(volume);
    if (volume->has_value()) { CHECK(extensions_in(**volume).empty()); }
}

TEST_CASE("a rest is as short within a scene as without one", "[rest]") {
    PathStrings scene;
    Alphabet alphabet;
    for (const char* label : {"floor", "wall", "lamp"}) {
        alphabet.scattering.push_back({EventType::reflection, Scatter::diffuse, 2, {label, "diffuse"}});
        alphabet.scattering.push_back({EventType::reflection, Scatter::glossy, 4, {label, "coat"}});
    }
    alphabet.terminals = {{EventType::light, Scatter::none, 0, {"key"}}, {EventType::light, Scatter::none, 0, {}}};
    scene.alphabet = alphabet;
    scene.max_depth = 5;
    for (const auto& set : {channels_of({{"key", "C.*<L.'key'>"}}), channels_of({{"floor", "C<RD'floor'>.*"}})}) {
        const auto without = rest_expression(set);
        const auto with = rest_expression(set, std::nullopt, scene);
        REQUIRE(without);
        REQUIRE(with);
        REQUIRE(without->has_value());
        REQUIRE(with->has_value());
        CHECK((*with)->size() <= (*without)->size());
    }
}

TEST_CASE("extensions are found outside labels and comments", "[extensions]") {
    CHECK(extensions_in("C(D[DS]*[LO])|[LO]").empty());
    CHECK(extensions_in("C<RD'BVG!&-$#'>{3}.*[^'a']").empty());
    CHECK(extensions_in("CV?B") == std::vector<std::string>{"V", "?", "B"});
    CHECK(extensions_in("C.{1,2}L-CDL") == std::vector<std::string>{"{n,m}", "-"});
    CHECK(extensions_in("C<RD'fl*'>L # V").size() == 3);
    CHECK(names_volume("C<V.'fog'>.*"));
    CHECK_FALSE(names_volume("C<.D'V'>.* # V"));
}

TEST_CASE("in osl a quoted label is a label, whatever letter it is", "[osl]") {
    // Open Shading Language's parser reads only the unquoted x as NONE; quoted texts are compared verbatim.
    CHECK(matches_path("C<RD'x'>L", "C,- R,D,x L,-,x"));
    CHECK(matches_path("C<RD'x'>L", "C,- R,D,x L,-"));
    CHECK_FALSE(matches_path("C<RD'x'>L", "C,- R,D L,-"));
    CHECK_FALSE(matches_path("C<RDx>L", "C,- R,D,x L,-"));
    CHECK_FALSE(matches_path("C<RDx>L", "C,- R,D L,-"));
    CHECK(matches_path("C'x'L", "C,- R,D,x L,-"));
    CHECK(matches_path("CDL", "C,- R,D,x L,-,x"));
    CHECK(matches_path("C<R[xD]>L", "C,- R,D L,-"));
    CHECK(matches_path("C<V[xD]>L", "C,- V,- L,-"));
    CHECK(matches_path("C<Vx>L", "C,- V,- L,-"));
    CHECK_FALSE(matches_path("C<V'x'>L", "C,- V,- L,-"));
    CHECK(matches_path("C<R[^'x']>L", "C,- R,D L,-"));
    CHECK(matches_path("C<V[^'x']>L", "C,- V,- L,-"));
    CHECK(matches_path("C<RD[^'x']>L", "C,- R,D,y L,-"));
    CHECK_FALSE(matches_path("C<RD[^'x']>L", "C,- R,D,x L,-"));
    // Quoted basic symbols are these symbols, and wildcards do not match labels with these names.
    CHECK(matches_path("C<'R''D'>L", "C,- R,D L,-"));
    CHECK_FALSE(matches_path("CDL", "C,- R,D,D L,-"));
    CHECK(matches_path("C<RD'D'>L", "C,- R,D,D L,-"));
    // Quoted, '.' is the wildcard inside <...> and a label outside.
    CHECK(matches_path("C<RD'.'>L", "C,- R,D,y L,-"));
    CHECK_FALSE(matches_path("C'.'L", "C,- R,D,y L,-"));
    CHECK(matches_path("C'.'L", "C,- R,D,. L,-"));
}

TEST_CASE("in renderman quoted labels are labels, also if they look like letters", "[renderman]") {
    const auto is = [](const std::string& expression, const std::string& events) {
        return matches_path(expression, events, Dialect::renderman);
    };
    for (const char* label :
         {"x", "C", "D", ".", "L", "V", "^", "[", "]", "<", ">", "(", "|", "#", ";", "$", "-", "&"}) {
        INFO(label);
        const std::string event = "C,- R,D,'" + std::string(label) + "' L,-";
        CHECK(is("C<RD'" + std::string(label) + "'>L", event));
        CHECK(is("C'" + std::string(label) + "'L", event));
        CHECK_FALSE(is("C<RD'" + std::string(label) + "'>L", "C,- R,D,y L,-"));
        CHECK_FALSE(is("C<RD[^'" + std::string(label) + "']>L", event));
        CHECK(is("CDL", event));
    }
    CHECK(is("C<RD'\\''>L", "C,- R,D,'\\'' L,-"));
    CHECK(is("C<RD'\\\\'>L", "C,- R,D,'\\\\' L,-"));
    CHECK(is("C<RD'\\*'>L", "C,- R,D,'*' L,-"));
    CHECK_FALSE(is("C<RD'\\*'>L", "C,- R,D,a L,-"));
    CHECK(is("C<RD''>L", "C,- R,D L,-"));
    CHECK_FALSE(is("C<RD''>L", "C,- R,D,a L,-"));
    CHECK_FALSE(is("C<RD[^'']>L", "C,- R,D L,-"));
}
