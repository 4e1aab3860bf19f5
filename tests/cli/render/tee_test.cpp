// Channels that a scene's textures write, requested as AOVs.
#include <algorithm>

#include <catch2/catch.hpp>

#include "display/output/reader/exr_reader.h"
#include "support.h"

using namespace raylex::test;
using raylex::display::read_exr;

TEST_CASE("--aov and a job's aovs request the channel of a tee texture, and misspelt names get a suggestion") {
    const Folder folder;
    std::string scene = small_scene();
    const std::string world = "WorldBegin";
    REQUIRE(scene.find(world) != std::string::npos);
    scene.insert(scene.find(world) + world.size(), R"(
Texture "paint" "spectrum" "tee" "rgb input" [0.5 0.25 0.125] "string channel" "paint"
Material "diffuse" "texture reflectance" "paint"
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-1e3 -1e-2 1e3 1e3 -1e-2 1e3 1e3 -1e-2 -1e3 -1e3 -1e-2 -1e3]
)");
    folder.write("room.pbrt", scene);
    Outcome outcome = run_raylex(folder, "render room.pbrt --aov paint --aov Nn");
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    auto image = read_exr(folder.path("room.exr"));
    REQUIRE(image);
    REQUIRE(image->layer("paint") != nullptr);
    const auto planes = image->layer("paint")->triple();
    double most[3] = {};
    for (std::size_t c = 0; c < 3; ++c)
        for (const float value : planes[c]->values) most[c] = std::max(most[c], double(value));
    CHECK(most[0] > 0);  // in the rendering space, the scene's own: the numbers as written
    CHECK(most[1] == Approx(most[0] / 2));
    CHECK(most[2] == Approx(most[0] / 4));

    folder.write("job.toml", "[scene]\nfile = \"room.pbrt\"\n[channels]\naovs = [\"pant\"]\n");
    outcome = run_raylex(folder, "render job.toml");
    CHECK(outcome.code == 2);
    CHECK(outcome.err.find("did you mean 'paint'") != std::string::npos);
    CHECK(outcome.err.find("job.toml:4") != std::string::npos);
}
