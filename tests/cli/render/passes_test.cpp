// Passes from the command line: the file, its header, its proof, and refusals.
#include <catch2/catch.hpp>

#include "support.h"

using namespace raylex::test;

TEST_CASE("render sums passes and records each of them in the file", "[passes]") {
    const SceneFolder folder;
    const Outcome rendered =
        run_raylex(folder,
                   "render room.pbrt -o room.exr --layer-passes --aov Nn --light-groups --statistics beauty=mse "
                   "--pass path:rest --pass 'path:C<RD>[LB]:spp=8:name=direct' --lpe 'direct=C<RD>[LB]'");
    INFO(rendered.err);
    CHECK(rendered.code == 0);
    CHECK(contains(rendered.out, "direct: path, 8 samples per pixel"));
    const Outcome verified = run_raylex(folder, "verify room.exr");
    CHECK(verified.code == 0);
    for (const char* each : {"passes", "light_groups", "auto"}) CHECK(contains(verified.out, each));
    auto image = raylex::display::read_exr(folder.path("room.exr"));
    REQUIRE(image);
    CHECK(contains(image->attributes.at("raylex/passes"), "path: path, 4 samples per pixel"));
    CHECK(contains(image->attributes.at("raylex/passes"), "takes C<RD>[LB]"));
    CHECK(image->attributes.at("lpe/direct") == "C<RD>[LB]");
    CHECK(plane(*image, "direct", "G") == plane(*image, "pass_direct", "G"));
    // a job has the same passes
    folder.write(
        "job.toml",
        "[scene]\nfile = 'room.pbrt'\n[render]\nlayer_passes = true\n[[pass]]\nmethod = 'path'\ntakes = 'rest'\n"
        "[[pass]]\nmethod = 'path'\ntakes = 'direct'\nspp = 8\nname = 'direct'\n"
        "[[channel]]\nname = 'direct'\nlpe = 'C<RD>[LB]'\n");
    REQUIRE(run_raylex(folder, "render job.toml -o job.exr --threads 1").code == 0);
    auto of_job = raylex::display::read_exr(folder.path("job.exr"));
    REQUIRE(of_job);
    for (const char* layer : {"beauty", "pass_direct"}) CHECK(plane(*of_job, layer, "G") == plane(*image, layer, "G"));
}

TEST_CASE("a pass does not warn about paths that other passes take", "[passes]") {
    const SceneFolder folder;
    const std::string scene = "render '" + source_dir() + "/experiments/scenes/glass-caustic/scene.pbrt'";
    const std::string small = " --resolution 8x8 --spp 1 -o a.exr";
    CHECK(contains(run_raylex(folder, scene + small + " --integrator lighttracer").err, "missing from the image"));
    const Outcome outcome = run_raylex(folder, scene + small + " --pass path:rest --pass 'lighttracer:C<RD>S+[<L.>O]'");
    CHECK(outcome.code == 0);
    CHECK(outcome.err.find("missing from the image") == std::string::npos);
}

TEST_CASE("render refuses passes that are no partition or that it does not support", "[passes]") {
    const SceneFolder folder;
    const Outcome hole = run_raylex(folder, "render room.pbrt -o a.exr --pass 'path:C<RD>.*'");
    CHECK(hole.code == 1);
    CHECK(contains(hole.err, "no pass takes camera, light"));
    CHECK(contains(hole.err, "Nothing was rendered"));
    check_refused(folder, "render room.pbrt -o a.exr --pass path:rest --shard 1/2", {"passes do not support shards"});
    check_refused(folder, "render room.pbrt -o a.exr --pass path:rest --checkpoint 60s",
                  {"passes do not support checkpoints"});
    check_refused(folder, "render room.pbrt -o a.exr --layer-passes", {"--layer-passes without passes"});
    check_refused(folder, "render room.pbrt -o a.exr --pass rest", {"--pass", "expected METHOD:EXPR"});
}
