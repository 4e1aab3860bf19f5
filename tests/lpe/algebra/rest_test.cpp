// The rest of channels as a readable expression.
#include <catch2/catch.hpp>

#include <random>
#include <string>
#include <vector>

#include "lpe/algebra/proofs/check.h"
#include "lpe/algebra/wording/regex_printing.h"
#include "lpe/shipped.h"

using namespace raylex;
using namespace raylex::lpe;

namespace {

std::vector<ChannelSource> numbered(const std::vector<std::string>& expressions, Dialect dialect = Dialect::renderman) {
    std::vector<ChannelSource> result;
    for (const std::string& expression : expressions) {
        ChannelSource source;
        source.name = "c" + std::to_string(result.size());
        source.expression = expression;
        source.dialect = dialect;
        result.push_back(source);
    }
    return result;
}

std::string rest_of(const std::vector<std::string>& expressions) {
    const auto text = rest_expression(numbered(expressions));
    return !text ? "error: " + text.error().message : text->value_or("none");
}

std::string plain(const std::string& expression) {
    const auto text = plain_expression(numbered({expression}).front());
    return !text ? "error: " + text.error().message : text->value_or("none");
}

}  // namespace

TEST_CASE("a rest is written in a readable form", "[rest]") {
    CHECK(rest_of({"C<RD>.*"}) == "C([STV].*)?[LO]");
    CHECK(rest_of({"C[DS]*[LO]"}) == "C[DS]*V.*[LO]");
    CHECK(rest_of({"C.*<L.'key'>"}) == "C.*[<L.[^'key']>O]");
    CHECK(rest_of({"C<RD'floor'>.*"}) == "C([^<RD'floor'>].*)?[LO]");
    CHECK(rest_of({"CD2.*"}) == "C([^D2].*)?[LO]");
    CHECK(rest_of({"C<RD'wall*'>.*", "C[LO]"}) == "C[^<RD'wall*'>].*[LO]");
}

TEST_CASE("sets of events are written compactly", "[rest]") {
    CHECK(plain("C[<RD1><RD2><RD3><RD4>].*") == "C<R[D1D2D3D4]>.*[LO]");
    CHECK(plain("C[<RD><TD><RS><TS>][LO]") == "C[DS][LO]");
    CHECK(plain("C[<RG><TG><RS><TS>]*[LO]") == "CS*[LO]");
    CHECK(plain("C(DS)|(DD)L") == "CD[DS]L");
    CHECK(plain("C<RD['a''b']>[<L.>O]") == "C<RD['a''b']>[LO]");
    CHECK(plain("C(D|S)(D|S)(D|S)*[LO]") == "C[DS]{2,}[LO]");
    CHECK(plain("C.*-C[LO]") == "C.+[LO]");
}

TEST_CASE("there is no expression for an empty rest or a rest without a short expression", "[rest]") {
    CHECK(rest_of({"C.*"}) == "none");
    CHECK(rest_of({"C[DS]*[LO]", "C[DS]*V.*"}) == "none");
    // Testing whether the 12th event from the end is D takes 2^12 states.
    CHECK(rest_of({"C.*D.{11}[LO]"}) == "none");
    CHECK(rest_of({"C<RD"}).find("error") == 0);
    const auto overlap = rest_expression(numbered({"CD.*", "C<RD>.*"}));
    REQUIRE(overlap);
    CHECK_FALSE(overlap->has_value());  // no rest completes channels that share paths
}

TEST_CASE("the rest of a split of less than the beauty stays inside it", "[rest]") {
    ChannelSource beauty;
    beauty.expression = "C<RD>.*";
    const auto text = rest_expression(numbered({"C<RD>[LO]"}), beauty);
    REQUIRE(text);
    REQUIRE(text->has_value());
    CHECK(**text == "C<RD>.+[LO]");
}

TEST_CASE("the words of a scene make rests shorter", "[rest]") {
    PathStrings words;
    words.volume = false;
    words.emission = false;
    words.background = false;
    const auto text = rest_expression(numbered({"C[DS]+L"}), std::nullopt, words);
    REQUIRE(text);
    REQUIRE(text->has_value());
    CHECK((*text == "CL" || *text == "C[LO]"));
}

TEST_CASE("every printed rest is proved: random sets of channels", "[rest][gate]") {
    const std::vector<std::string> pieces{"D",       "S",    "<RD>", "<TS>",  "V",     ".",   "'a'",
                                          "<RD'b'>", "[DS]", "[^D]", "<RS4>", "(D|S)", "(SV)"};
    const std::vector<std::string> repeats{"", "", "*", "+", "?", "{2}"};
    const std::vector<std::string> ends{"L", "O", "[LO]", "<L.'k'>", "B"};
    std::mt19937 random(20261121);
    const auto pick = [&](const std::vector<std::string>& from) { return from[random() % from.size()]; };
    int printed = 0;
    for (int round = 0; round < 100; ++round) {
        std::string expression = "C";
        for (unsigned k = random() % 4; k > 0; --k) { expression += pick(pieces) + pick(repeats); }
        expression += pick(ends);
        INFO(expression);
        auto channels = numbered({expression});
        const auto text = rest_expression(channels);
        REQUIRE(text);
        if (*text) {
            ++printed;
            CHECK((*text)->size() <= longest_printed_expression);
            channels.push_back(numbered({**text}).front());
            channels.back().name = "rest";
            const auto proof = check_partition(channels);
            REQUIRE(proof);
            CHECK(proof->result == SplitProof::partition);
        }
        const auto same = plain_expression(channels.front());
        REQUIRE(same);
        if (*same) {
            const auto difference = find_difference(channels.front(), numbered({**same}).front());
            REQUIRE(difference);
            CHECK_FALSE(difference->has_value());
        }
    }
    CHECK(printed > 60);  // most sets of this size have a short rest
}

TEST_CASE("a part of the shipped partition has a short rest", "[rest]") {
    const auto all = shipped_partition();
    for (std::size_t left_out = 0; left_out < all.size(); ++left_out) {
        std::vector<std::string> kept;
        for (std::size_t k = 0; k < all.size(); ++k) {
            if (k != left_out) { kept.emplace_back(all[k].expression); }
        }
        INFO(all[left_out].name);
        CHECK(rest_of(kept) != "none");
    }
}
