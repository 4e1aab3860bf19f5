// Why a path does not match: the longest live prefix, and the events that were expected after it.
#include <catch2/catch.hpp>

#include <algorithm>
#include <string>
#include <vector>

#include "lpe/algebra/explanation/why_not.h"
#include "lpe/match.h"
#include "tests/lpe/oracle.h"
#include "tests/lpe/sources.h"

using namespace raylex::lpe;
using lpe_test::source;

namespace {

struct WhyNotCase {
    std::string expression, path;
    std::size_t live;
    std::string wanted;
    std::vector<std::string> pieces;  // with columns: "3:S"
};

std::vector<std::string> pieces_of(const WhyNot& why) {
    std::vector<std::string> texts;
    for (const WantedPiece& piece : why.pieces) {
        texts.push_back(std::to_string(piece.begin + 1) + ":" +
                        why.expression.substr(piece.begin, piece.end - piece.begin));
    }
    return texts;
}

}  // namespace

TEST_CASE("the longest live prefix and the pieces that could follow are reported") {
    const std::vector<WhyNotCase> cases{
        {"CDSL", "C,- R,D,floor L,-,key", 2, "one specular scattering", {"3:S"}},
        {"CDL", "R,D L,-", 0, "the camera", {"1:C"}},
        {"CDL", "C,- R,D L,- L,-", 3, "", {}},
        {"CD*L", "C,- R,D", 2, "one diffuse scattering or a light", {"2:D", "4:L"}},
        {"C(D|(SD))*L", "C,- R,D R,S", 3, "one diffuse scattering", {"7:D"}},
        {"CDSD", "C,- R,S", 1, "one diffuse scattering", {"2:D"}},
        {"CD+[<L.'key'>O]",
         "C,- R,D L,-,fill",
         2,
         "one diffuse scattering, a light of group 'key' or emission",
         {"2:D", "5:<L.'key'>", "14:O"}},
        {"osl:CDSDL", "C,- R,D R,S R,G L,-", 3, "one diffuse scattering", {"4:D"}},
        {"osl:CL", "C,- B,-", 1, "a light", {"2:L"}},
        {"osl:C<RD'floor'>L", "C,- R,D L,-", 1, "one diffuse reflection off 'floor'", {"2:<RD'floor'>"}},
    };
    for (const WhyNotCase& entry : cases) {
        CAPTURE(entry.expression, entry.path);
        const auto path = parse_placed_events(entry.path);
        REQUIRE(path);
        const auto why = why_not(source(entry.expression), path->events);
        REQUIRE(why);
        CHECK_FALSE(why->matches);
        CHECK(why->live_events == entry.live);
        CHECK(why->wanted == entry.wanted);
        CHECK(pieces_of(*why) == entry.pieces);
    }
}

TEST_CASE("a misspelt label is reported with the likely one") {
    const auto near = why_not(source("C<RD'floor'>L"), *parse_events("C,- R,D,flor L,-"));
    REQUIRE(near);
    CHECK(near->hint == "its label 'flor' is not 'floor'; did you mean 'floor'?");
    const auto none = why_not(source("C<RD'floor'>L"), *parse_events("C,- R,D L,-"));
    CHECK(none->hint == "it has no label where 'floor' is required");
    CHECK(why_not(source("C<RD'floor'>L"), *parse_events("C,- R,S,flor L,-"))->hint.empty());
}

TEST_CASE("only a few of many labels are listed") {
    std::string expression = "C[";
    for (int k = 0; k < 500; ++k) { expression += "<R.'object" + std::to_string(k) + "'>"; }
    const auto why = why_not(source(expression + "]L"), *parse_events("C,- R,D L,-"));
    REQUIRE(why);
    CHECK(why->wanted.size() < 200);
    CHECK(why->wanted.find("others") != std::string::npos);
}

TEST_CASE("a matching path, an empty language and a path with too many events give different answers") {
    CHECK(why_not(source("CDL"), *parse_events("C,- R,D L,-"))->matches);
    CHECK_FALSE(why_not(source("CDL - C.*"), *parse_events("C,-"))->any_path);
    const auto longer = why_not(source("CD*"), *parse_events("C,- R,D L,-"));
    CHECK(longer->complete);
    CHECK(longer->live_events == 2);
    CHECK_FALSE(why_not(source("CD("), {}));
    // Operators on languages have no single piece to report, but the possible next events are known.
    const auto difference = why_not(source("C.* - CD.*"), *parse_events("C,- R,D L,-"));
    CHECK(difference->live_events == 1);
    CHECK(difference->pieces.empty());
    CHECK(difference->wanted.find("specular") != std::string::npos);
    // Too large for markers: the answer is the same, but without pieces.
    const auto large = why_not(source("C(D{2}){900}L"), *parse_events("C,- R,D R,S"));
    REQUIRE(large);
    CHECK(large->live_events == 2);
    CHECK(large->wanted == "one diffuse scattering");
}

TEST_CASE("no path that continues like the refused one is accepted, and the expected events are live") {
    for (const Dialect dialect : {Dialect::renderman, Dialect::osl}) {
        const auto paths = oracle::all_paths(dialect, 3);
        const std::vector<std::string> expressions =
            dialect == Dialect::renderman
                ? std::vector<std::string>{"CD*L",    "C(D|SS)L", "C.D",       "C[^D]*O",
                                           "C<RD>?.", "!(CD.*)",  "C.* & .*L", "CS{2}"}
                : std::vector<std::string>{"CD*L", "C(D|SS)L", "C.D", "C[^D]*O", "C<R>*.", "CS{2}"};
        for (const std::string& text : expressions) {
            ChannelSource channel = source(text);
            channel.dialect = dialect;
            std::vector<const oracle::Path*> accepted;
            for (const oracle::Path& path : paths) {
                if (*match(text, path, dialect)) { accepted.push_back(&path); }
            }
            std::size_t seen = 0;
            for (const oracle::Path& path : paths) {
                if (++seen % 37 != 0) {  // a prime step gives a varied sample of a large list
                    continue;
                }
                const auto why = why_not(channel, path);
                REQUIRE(why);
                CAPTURE(text, to_text(path), why->live_events);
                CHECK(why->matches == (std::find(accepted.begin(), accepted.end(), &path) != accepted.end()));
                if (why->matches || why->live_events == path.size()) { continue; }
                const std::size_t failed = why->live_events + 1;
                const bool goes_on = std::any_of(accepted.begin(), accepted.end(), [&](const oracle::Path* other) {
                    return other->size() >= failed &&
                           std::equal(path.begin(), path.begin() + static_cast<std::ptrdiff_t>(failed), other->begin());
                });
                CHECK_FALSE(goes_on);
            }
        }
    }
}
