// "regularize": its glossy lobes, which materials do not have, in sums, proofs, warnings and atlases.
#include <catch2/catch.hpp>

#include <algorithm>
#include <string>

#include "tests/experiments/support.h"

using namespace raylex;
using namespace raylex::test;

TEST_CASE("layers of a regularized render sum, are proved, and can be made from an atlas", "[lpe][law1][atlas]") {
    const Folder folder;
    folder.write("ball.pbrt", R"(Film "rgb" "integer xresolution" 10 "integer yresolution" 10
Sampler "independent" "integer pixelsamples" 64
Integrator "path" "bool regularize" true
LookAt 0 6 -6  0 0 0  0 1 0
Camera "perspective" "float fov" 30
WorldBegin
LightSource "distant" "point3 from" [0 1 0] "point3 to" [0 0 0]
Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
AttributeBegin Rotate -90 1 0 0 Shape "disk" "float radius" 20 AttributeEnd
Material "dielectric"
Translate 0 1.2 0
Shape "sphere" "float radius" 1)");
    const std::string layers = " --lpe tg='C<RD><TG>+L' --lpe rd='C<RD>L'";
    const Outcome outcome = run_raylex(folder, "render ball.pbrt -o ball.exr --atlas ball.atlas.exr" + layers);
    INFO(outcome.out << outcome.err);
    REQUIRE(outcome.code == 0);
    const std::string said = outcome.out + outcome.err;
    CHECK(contains(said, "sum to beauty"));
    CHECK_FALSE(contains(said, "DO NOT SUM"));
    CHECK_FALSE(contains(said, "matches no path"));
    float most = 0;
    for (const float value : plane(folder, "ball.exr", "tg", "G")) most = std::max(most, value);
    CHECK(most > 0);  // light through the ball behind the floor
    const Outcome proof = run_raylex(folder, "lpe check --scene ball.pbrt tg='C<RD><TG>+L' ts='C<RD><TS>+L'");
    CHECK_FALSE(contains(proof.out + proof.err, "matches no path"));
    const Outcome requested = run_raylex(folder, "ask ball.atlas.exr --lpe tg='C<RD><TG>+L' -o asked.exr");
    INFO(requested.out << requested.err);
    REQUIRE(requested.code == 0);
    CHECK_FALSE(contains(requested.out + requested.err, "matches no path"));
    CHECK(plane(folder, "asked.exr", "tg", "G") == plane(folder, "ball.exr", "tg", "G"));
}
