// The meaning of the renderman dialect, construct by construct.
#include <catch2/catch.hpp>

#include "lpe/match.h"

using namespace raylex::lpe;

namespace {

bool accepts(const std::string& expression, const std::string& events) {
    const auto path = parse_events(events);
    REQUIRE(path);
    const auto found = match(expression, *path, Dialect::renderman);
    INFO(expression);
    REQUIRE(found);
    return *found;
}

}  // namespace

TEST_CASE("L is every light, B the environment alone, O emission", "[renderman]") {
    for (const char* light : {"CL", "C<L.>", "C<L>"}) {
        CHECK(accepts(light, "C,- L,-"));
        CHECK(accepts(light, "C,- B,-,sky"));
        CHECK_FALSE(accepts(light, "C,- O,-"));
    }
    CHECK(accepts("CB", "C,- B,-"));
    CHECK_FALSE(accepts("CB", "C,- L,-"));
    CHECK(accepts("C<L.'sky'>", "C,- B,-,sky"));
    CHECK_FALSE(accepts("C<L.'sky'>", "C,- L,-,key"));
    CHECK_FALSE(accepts("C[<L.>O]-CB", "C,- B,-"));
    CHECK(accepts("C[<L.>O]-CB", "C,- O,-"));
}

TEST_CASE("S is every specular lobe, G the glossy ones, and numbers select lobes", "[renderman]") {
    CHECK(accepts("CSL", "C,- R,S L,-"));
    CHECK(accepts("CSL", "C,- T,G L,-"));
    CHECK(accepts("CGL", "C,- R,G L,-"));
    CHECK_FALSE(accepts("CGL", "C,- R,S L,-"));
    CHECK(accepts("CS8L", "C,- R,G8 L,-"));
    CHECK(accepts("CS8L", "C,- T,S8 L,-"));
    CHECK_FALSE(accepts("CS8L", "C,- R,S L,-"));
    CHECK(accepts("CSL", "C,- R,S8 L,-"));
    CHECK(accepts("C<TS8>[DS]*[<L.>O]", "C,- T,S8 R,D O,-"));
    CHECK(accepts("CD2[<L.>O]", "C,- R,D2 L,-"));
    CHECK_FALSE(accepts("CD2[<L.>O]", "C,- R,D3 L,-"));
    CHECK_FALSE(accepts("CDL", "C,- V,- L,-"));
}

TEST_CASE("user events match only when they are named", "[renderman]") {
    CHECK(accepts("C<.S'passthru'>*((U2L)|O)", "C,- R,S,passthru U2,- L,-"));
    CHECK(accepts("C<.S'passthru'>*((U2L)|O)", "C,- O,-"));
    CHECK(accepts("C<.U2'albedo'>L", "C,- U2,-,albedo L,-"));
    for (const char* wild : {"C.L", "C.*", "C[^D]L", "C<..>L", "!(CDL)", "C<.[^D]>L"}) {
        CHECK_FALSE(accepts(wild, "C,- U2,- L,-"));
    }
    CHECK_FALSE(accepts("CU2L", "C,- U12,- L,-"));
}

TEST_CASE("pass-through events leave no event", "[renderman]") {
    CHECK(accepts("CDL", "C,- T,s R,D T,s,leaf T,s L,-"));
    CHECK(accepts("CL", "C,- T,s L,-"));
    CHECK_FALSE(accepts("C.L", "C,- T,s L,-"));
    CHECK_FALSE(accepts("!(CL)", "C,- T,s L,-"));
}

TEST_CASE("| joins only its neighbours", "[renderman]") {
    CHECK(accepts("CD|(SD)L", "C,- R,D L,-"));
    CHECK(accepts("CD|(SD)L", "C,- R,S R,D L,-"));
    CHECK_FALSE(accepts("CD|(SD)L", "C,- R,D R,S R,D L,-"));
    CHECK_FALSE(accepts("CD|(SD)L", "C,- R,D"));
    CHECK(accepts("CD|S|VL", "C,- V,- L,-"));
    CHECK(accepts("CD+|S L", "C,- R,D R,D L,-"));
}

TEST_CASE("labels: first slot, later slots, sets; an absent label is empty", "[renderman]") {
    CHECK(accepts("C<RD'floor'>L", "C,- R,D,floor,diffuse L,-"));
    CHECK(accepts("C<RD.'diffuse'>L", "C,- R,D,floor,diffuse L,-"));
    CHECK(accepts("C<RD.'diffuse'>L", "C,- R,D,'',diffuse L,-"));
    CHECK_FALSE(accepts("C<RD'floor'>L", "C,- R,D L,-"));
    CHECK(accepts("C<RD[^'floor']>L", "C,- R,D L,-"));
    CHECK(accepts("C<RD''>L", "C,- R,D L,-"));
    CHECK(accepts("C<RD['floor''wall']>L", "C,- R,D,wall L,-"));
    CHECK(accepts("C'floor'L", "C,- T,S,floor L,-"));
    CHECK(accepts("C[^'floor' V]L", "C,- R,D,wall L,-"));
    CHECK_FALSE(accepts("C[^'floor' V]L", "C,- V,- L,-"));
    CHECK_FALSE(accepts("C[^<RD'floor'>]L", "C,- R,D,floor L,-"));
    CHECK(accepts("C[^<RD'floor'>]L", "C,- R,S,floor L,-"));
}

TEST_CASE("label globs", "[renderman]") {
    CHECK(accepts("C<RD'set_*'>L", "C,- R,D,set_floor L,-"));
    CHECK_FALSE(accepts("C<RD'set_*'>L", "C,- R,D,hero L,-"));
    CHECK(accepts("C<RD'*'>L", "C,- R,D L,-"));
    CHECK_FALSE(accepts("C<RD'?*'>L", "C,- R,D L,-"));
    CHECK(accepts("C<RD'a?c'>L", "C,- R,D,abc L,-"));
    CHECK(accepts("C<RD'a?c'>L",
                  "C,- R,D,a\xC3\xA9"
                  "c L,-"));
    CHECK_FALSE(accepts("C<RD'a?c'>L", "C,- R,D,abbc L,-"));
    CHECK(accepts("C<RD'a\\*'>L", "C,- R,D,a* L,-"));
    CHECK_FALSE(accepts("C<RD'a\\*'>L", "C,- R,D,ab L,-"));
    CHECK(accepts("C<RD['a*''*z']>L-C<RD'a*z'>L", "C,- R,D,yz L,-"));
    CHECK_FALSE(accepts("C<RD['a*''*z']>L-C<RD'a*z'>L", "C,- R,D,a_z L,-"));
    CHECK(accepts("C<RD[^'a*''abc']>L", "C,- R,D,b L,-"));
    CHECK_FALSE(accepts("C<RD[^'a*''abc']>L", "C,- R,D,abc L,-"));
}

TEST_CASE("repetitions, blanks, comments and operators on languages", "[renderman]") {
    CHECK(accepts("C D? L", "C,- L,-"));
    CHECK(accepts("C D? L", "C,- R,D L,-"));
    CHECK_FALSE(accepts("C D? L", "C,- R,D R,D L,-"));
    CHECK(accepts("C D{2,3} L", "C,- R,D R,D R,D L,-"));
    CHECK_FALSE(accepts("C D{2,3} L", "C,- R,D L,-"));
    CHECK(accepts("CD{0}L", "C,- L,-"));
    CHECK(accepts("C # the camera\n [ D S ] + # lobes\n < L . 'key' >", "C,- R,S R,D L,-,key"));
    CHECK(accepts("C.* & .*L - C.*S.*", "C,- R,D L,-"));
    CHECK_FALSE(accepts("C.* & .*L - C.*S.*", "C,- R,D R,G L,-"));
    CHECK(accepts("C(.* - .*V.*)L", "C,- R,D L,-"));
    CHECK_FALSE(accepts("C(.* - .*V.*)L", "C,- R,D V,- L,-"));
    CHECK(accepts("noclamp; unoccluded; CDL", "C,- R,D L,-"));
}
