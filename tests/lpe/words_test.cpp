#include "lpe/path_strings.h"

#include <ctime>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "lpe/algebra/proofs/check.h"

namespace raylex::lpe {
namespace {

Event reflection(Scatter scatter, const std::string& object, const std::string& lobe) {
    return {EventType::reflection, scatter, 0, {object, lobe}};
}
Event light(const std::string& group) {
    return {EventType::light, Scatter::none, 0, {group}};
}

SplitProof result(const std::vector<ChannelSource>& channels, const PathStrings& words) {
    const auto report = check_partition(channels, std::nullopt, words);
    INFO((report ? report->summary : report.error().to_string()));
    REQUIRE(report.ok());
    return report->result;
}

bool can_match(const std::string& expression, const PathStrings& words, Dialect dialect = Dialect::renderman) {
    const auto word = find_path_string({"", expression, dialect}, words);
    REQUIRE(word.ok());
    return word->has_value();
}

}  // namespace

TEST_CASE("a depth limit restricts W to words with that many scatterings") {
    PathStrings words;
    words.max_depth = 2;
    CHECK(can_match("C..L", words));
    CHECK_FALSE(can_match("C...L", words));
    const std::vector<ChannelSource> by_bounce{{"none", "C[LO]"}, {"one", "C.[LO]"}, {"two", "C..[LO]"}};
    CHECK(result(by_bounce, words) == SplitProof::partition);
    words.max_depth = 3;
    CHECK(result(by_bounce, words) == SplitProof::missed);
    words.max_depth = 0;
    CHECK(can_match("CL", words));
    CHECK_FALSE(can_match("C.L", words));
}

TEST_CASE("pass-through events do not count as scatterings") {
    PathStrings words;
    words.max_depth = 1;
    CHECK(can_match("CDL", words));
    CHECK(can_match("C<Ts><Ts>D<Ts>L", words, Dialect::osl));
    CHECK_FALSE(can_match("CD<Ts>DL", words, Dialect::osl));
    words.straight = false;
    CHECK_FALSE(can_match("C<Ts>DL", words, Dialect::osl));
}

TEST_CASE("a depth limit beyond the maximum is ignored, so that proofs never cover too few words") {
    PathStrings words;
    words.max_depth = 1'000'000;
    CHECK(can_match("CD{200}L", words));
}

TEST_CASE("proofs on an alphabet distinguish only what expressions name") {
    PathStrings words;
    words.alphabet =
        Alphabet{{reflection(Scatter::diffuse, "floor", "diffuse"), reflection(Scatter::diffuse, "wall", "diffuse"),
                  reflection(Scatter::glossy, "lamp_1", "coat"), reflection(Scatter::glossy, "lamp_2", "coat")},
                 {light(""), light("key")}};
    CHECK(result({{"floor", "C<RD'floor'>.*"}, {"rest", "C<RD'wall'>.*"}, {"lamps", "CG.*"}, {"seen", "CL"}}, words) ==
          SplitProof::partition);
    CHECK(result({{"a", "C<RD'floor'>.*"}, {"b", "C<RD[^'floor']>.*"}, {"lamps", "C<RG'lamp_*'>.*"}, {"seen", "CL"}},
                 words) == SplitProof::partition);
    CHECK(result({{"a", "CD.*"}, {"b", "C<RG'lamp_1'>.*"}, {"seen", "CL"}}, words) == SplitProof::missed);
    CHECK(result({{"key", "C.*<L.'key'>"}, {"other", "C.*<L.''>"}}, words) == SplitProof::partition);
    const auto word = find_path_string({"", "C<.G'*'>L"}, words);
    REQUIRE(word.ok());
    REQUIRE(word->has_value());
    CHECK((*word)->text == "C,- R,G,lamp_1,coat L,-");  // an event of the scene
}

TEST_CASE("proofs on ten thousand labels take as long as on the labels that are named", "[performance]") {
    PathStrings words;
    words.max_depth = 5;
    words.alphabet.emplace();
    for (int i = 0; i < 5'000; ++i) {
        words.alphabet->scattering.push_back(reflection(Scatter::diffuse, "object_" + std::to_string(i), "diffuse"));
        words.alphabet->scattering.push_back(reflection(Scatter::glossy, "object_" + std::to_string(i), "coat"));
    }
    words.alphabet->terminals = {light(""), light("key")};
    const std::clock_t start = std::clock();
    CHECK(result({{"one", "C<RD'object_7'>.*"}, {"others", "C<RD[^'object_7']>.*"}, {"coats", "CG.*"}, {"seen", "CL"}},
                 words) == SplitProof::partition);
    // About 2 ms; without merging labels the proof is refused (too many kinds of events). The rest of the bound is for
    // sanitizers.
    CHECK(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC < 0.5);
}

}  // namespace raylex::lpe
