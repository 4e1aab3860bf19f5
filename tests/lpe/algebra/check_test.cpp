// Proofs and counterexamples of the algebra.
#include <catch2/catch.hpp>

#include <algorithm>
#include <utility>

#include "lpe/algebra/proofs/check.h"
#include "lpe/match.h"
#include "lpe/shipped.h"
#include "tests/lpe/sources.h"

using namespace raylex::lpe;
using lpe_test::channel_of;
using lpe_test::channels_of;
using lpe_test::shipped;

namespace {

/// RenderMan's documented basic set, which has no volumes.
std::vector<ChannelSource> renderman_basic_set() {
    return channels_of({{"emissive", "C[<L.>O]"},
                        {"directDiffuse", "C<RD>[<L.>O]"},
                        {"indirectDiffuse", "C<RD>[DS]+[<L.>O]"},
                        {"subsurface", "C<TD>[DS]*[<L.>O]"},
                        {"directSpecular", "C<RS>[<L.>O]"},
                        {"indirectSpecular", "C<RS>[DS]+[<L.>O]"},
                        {"transmissive", "C<TS>[DS]*[<L.>O]"}});
}

bool equivalent(const std::string& a, const std::string& b, Dialect dialect = Dialect::renderman) {
    const auto difference = find_difference(channel_of(a, dialect), channel_of(b, dialect));
    REQUIRE(difference);
    return !difference->has_value();
}

}  // namespace

TEST_CASE("the shipped partition is a partition of the beauty in both dialects", "[check][law1]") {
    for (const Dialect dialect : {Dialect::renderman, Dialect::osl}) {
        const auto report = check_partition(shipped(dialect));
        REQUIRE(report);
        INFO(report->summary);
        CHECK(report->result == SplitProof::partition);
        const auto of_beauty =
            check_partition(shipped(dialect), channel_of(std::string(beauty_expression(dialect)), dialect));
        REQUIRE(of_beauty);
        CHECK(of_beauty->result == SplitProof::partition);
    }
}

TEST_CASE("no layer of the shipped partition can be omitted", "[check]") {
    for (const Dialect dialect : {Dialect::renderman, Dialect::osl}) {
        const auto all = shipped(dialect);
        for (std::size_t left_out = 0; left_out < all.size(); ++left_out) {
            auto some = all;
            some.erase(some.begin() + static_cast<std::ptrdiff_t>(left_out));
            const auto report = check_partition(some);
            REQUIRE(report);
            REQUIRE(report->result == SplitProof::missed);
            // The witness is a path of exactly the removed layer.
            const auto inside = match(all[left_out].expression, report->witness.events, dialect);
            REQUIRE(inside);
            CHECK(*inside);
        }
    }
}

TEST_CASE("RenderMan's basic set is a partition of surface light and misses volumes", "[check]") {
    PathStrings surfaces;
    surfaces.volume = false;
    const auto proved = check_partition(renderman_basic_set(), std::nullopt, surfaces);
    REQUIRE(proved);
    INFO(proved->summary);
    CHECK(proved->result == SplitProof::partition);

    const auto refuted = check_partition(renderman_basic_set());
    REQUIRE(refuted);
    CHECK(refuted->result == SplitProof::missed);
    CHECK(refuted->witness.text == "C,- V,- L,-");
    CHECK(refuted->witness.sentence == "camera, volume scattering, light");
    CHECK(refuted->channels.empty());
    CHECK(refuted->summary == "no channel counts camera, volume scattering, light (C,- V,- L,-)");
}

TEST_CASE("overlapping channels are refuted by the shortest path that both count", "[check]") {
    const auto report =
        check_partition(channels_of({{"diffuse", "C<RD>.*"}, {"key", "C.*<L.'key'>"}, {"rest", "C[^<RD>].*"}}));
    REQUIRE(report);
    CHECK(report->result == SplitProof::counted_twice);
    CHECK(report->witness.text == "C,- L,-,key");
    CHECK(report->channels == std::vector<std::size_t>{1, 2});

    const auto deeper = check_disjoint(channels_of({{"floor", "CS*<RD'floor'>.*"}, {"caustics", "CDS+<L.'key'>"}}));
    REQUIRE(deeper);
    CHECK_FALSE(deeper->disjoint);
    CHECK(deeper->witness.events.size() == 4);
    CHECK(deeper->witness.sentence.find("diffuse reflection off 'floor'") != std::string::npos);
    CHECK(deeper->witness.sentence.find("light 'key'") != std::string::npos);
    CHECK(deeper->summary.find("'floor' and 'caustics' both count") == 0);
}

TEST_CASE("paths outside a declared beauty are named", "[check]") {
    const auto channels = channels_of({{"direct", "CDL"}, {"all", "CD[DS]+L"}, {"glow", "CO"}});
    const auto report = check_partition(channels, channel_of("CD[DS]*L"));
    REQUIRE(report);
    CHECK(report->result == SplitProof::outside);
    CHECK(report->channels == std::vector<std::size_t>{2});
    CHECK(report->witness.text == "C,- O,-");
    const auto holds = check_partition({channels.data(), 2}, channel_of("CD[DS]*L"));
    REQUIRE(holds);
    CHECK(holds->result == SplitProof::partition);
}

TEST_CASE("the rest of channels completes a partition", "[check]") {
    auto channels = channels_of({{"caustics", "CDS+L"}, {"floor", "C<RD'floor'>L"}, {"rest", ""}});
    channels[2].rest_of = {0, 1};
    const auto report = check_partition(channels);
    REQUIRE(report);
    INFO(report->summary);
    CHECK(report->result == SplitProof::partition);

    auto bad = channels;
    bad[2].rest_of = {2};
    CHECK_FALSE(check_partition(bad));
}

TEST_CASE("channels with prefixes cannot be part of a partition", "[check][law7]") {
    const auto report = check_partition(channels_of({{"a", "lpe:unoccluded;noclamp;CDL"}}));
    REQUIRE_FALSE(report);
    CHECK(report.error().message.find("unoccluded") != std::string::npos);
    CHECK(report.error().file == "channel 'a'");
    const auto prefixes = expression_prefixes(channel_of("lpe:unoccluded;noclamp;CDL"));
    REQUIRE(prefixes);
    CHECK(*prefixes == std::vector<std::string>{"unoccluded", "noclamp"});
}

TEST_CASE("a scene's alphabet determines what a channel can match", "[check]") {
    PathStrings scene;
    scene.alphabet = Alphabet{{{EventType::reflection, Scatter::diffuse, 0, {"floor", "diffuse"}}},
                              {{EventType::light, Scatter::none, 0, {"key"}}}};
    const auto floor = find_path_string(channel_of("C<RD'floor'>L"), scene);
    REQUIRE(floor);
    REQUIRE(floor->has_value());
    CHECK((*floor)->text == "C,- R,D,floor,diffuse L,-,key");
    for (const char* never : {"C<RD'flor'>L", "CSL", "CV.*", "CB", "C<RD>U2L"}) {
        const auto word = find_path_string(channel_of(never), scene);
        REQUIRE(word);
        CHECK_FALSE(word->has_value());
    }
}

TEST_CASE("every expression for the beauty is recognised", "[check]") {
    CHECK(equivalent("C.*", "C[DSV]*[<L.>O]"));
    CHECK(equivalent("C.*", "C.*[LO]"));
    CHECK_FALSE(equivalent("C.*", "C[DS]*[<L.>O]"));
    CHECK(equivalent("C.*", "C[DGSsV]*[LOB]", Dialect::osl));
    CHECK_FALSE(equivalent("C.*", "C.*[LO]", Dialect::osl));
}

TEST_CASE("the identities of Boolean algebra hold", "[check]") {
    const std::string a = "C<RD'x'>.*";
    const std::string b = "C.*S.*L";
    CHECK(equivalent("!!(" + a + ")", a));
    CHECK(equivalent("!((" + a + ")&(" + b + "))", "(!(" + a + "))|(!(" + b + "))"));
    CHECK(equivalent("!((" + a + ")|(" + b + "))", "(!(" + a + "))&(!(" + b + "))"));
    CHECK(equivalent(a + "-" + b, a + "&!" + b));
    CHECK(equivalent("(" + a + ")-(" + a + ")", "C&L"));
    CHECK(equivalent("(" + a + "&" + b + ")|(" + a + "-" + b + ")", a));
    CHECK_FALSE(equivalent(a, b));
}

TEST_CASE("a word shows the difference between the two readings of '|'", "[check]") {
    // C(D|S)L against CD or SL.
    const auto warnings = expression_warnings(channel_of("CD|SL"));
    REQUIRE(warnings);
    REQUIRE(warnings->size() == 1);
    CHECK(warnings->front().find("C,- R,D L,-") != std::string::npos);
    CHECK(warnings->front().find("would not match") != std::string::npos);
    for (const char* same : {"C(D|S)L", "CDL", "C(D|S)*L"}) {
        const auto none = expression_warnings(channel_of(same));
        REQUIRE(none);
        CHECK(none->empty());
    }
    const auto ignored = expression_warnings(channel_of("(CDL)|(CSL)", Dialect::osl));
    REQUIRE(ignored);
    REQUIRE(ignored->size() == 1);
    CHECK(ignored->front().find("ignored") != std::string::npos);
}

TEST_CASE("a partition of osl channels is proved with straight-through events as letters", "[check]") {
    const auto partial =
        channels_of({{"emissive", "C[LOB]"}, {"surface", "C[DGS].*"}, {"volume", "CV.*"}}, Dialect::osl);
    const auto refuted = check_partition(partial);
    REQUIRE(refuted);
    CHECK(refuted->result == SplitProof::missed);
    CHECK(refuted->witness.text == "C,- T,s L,-");
    PathStrings opaque;
    opaque.straight = false;
    const auto proved = check_partition(partial, std::nullopt, opaque);
    REQUIRE(proved);
    CHECK(proved->result == SplitProof::partition);
}

TEST_CASE("no channels at all miss the shortest path of the beauty", "[check]") {
    const auto report = check_partition({});
    REQUIRE(report);
    CHECK(report->result == SplitProof::missed);
    CHECK(report->witness.text == "C,- L,-");
}
