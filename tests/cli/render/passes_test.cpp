// Passes from the command line: the file, its header, its proof, and refusals.
#include <catch2/catch.hpp>

#include <sstream>

#include "cli/experiment_support.h"

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
    const Outcome crop =
        run_raylex(folder, "render room.pbrt -o a.exr --crop 0,0,4,4 --pass path:rest --pass 'bdpt:C<RD>[LB]'");
    CHECK(crop.code == 2);
    CHECK(contains(crop.err, "the pass 'bdpt': a crop of a render"));
    CHECK_FALSE(contains(crop.out, "rendering"));  // before a ray of the other pass
    check_refused(folder, "render room.pbrt -o a.exr --pass rest", {"--pass", "expected METHOD:EXPR"});
}

TEST_CASE("render denoises the sum of passes", "[passes][gate]") {
    const SceneFolder folder;
    const std::string passes = " --pass path:rest --pass 'lighttracer:C<RD>[LB]:spp=32' --spp 8 --light-groups";
    const Outcome rendered = run_raylex(folder, "render room.pbrt -o a.exr --denoise --keep-noisy" + passes);
    INFO(rendered.err);
    REQUIRE(rendered.code == 0);
    CHECK(run_raylex(folder, "verify a.exr").code == 0);
    auto image = raylex::display::read_exr(folder.path("a.exr"));
    REQUIRE(image);
    CHECK(image->attributes.contains("raylex/denoised"));
    for (const float variance : plane(*image, "beauty_mse", "G")) CHECK(variance >= 0);
}

TEST_CASE("passes --propose writes a job that render accepts", "[passes]") {
    const SceneFolder folder;
    const std::string small = " --propose --pilot-samples 2";
    const Outcome proposed = run_raylex(folder, "passes room.pbrt --spp 4 -o p.toml" + small);
    INFO(proposed.err);
    REQUIRE(proposed.code == 0);
    CHECK(contains(proposed.out, "squared error"));
    CHECK(contains(proposed.err, "pilot of all paths by bdpt"));
    CHECK(run_raylex(folder, "render p.toml -o p.exr --resolution 8x8").code == 0);
    // a job keeps its other settings
    folder.write("job.toml", "[scene]\nfile = 'room.pbrt'\n[render]\nmax_depth = 2");
    const Outcome of_job = run_raylex(folder, "passes job.toml" + small);
    CHECK(of_job.code == 0);
    CHECK(contains(of_job.out, "max_depth = 2\n"));
    CHECK(contains(of_job.out, "\n[[pass]]\nmethod = "));
    folder.write("done.toml", "[scene]\nfile = 'room.pbrt'\n[[pass]]\nmethod = 'path'\ntakes = 'rest'\n");
    check_refused(folder, "passes done.toml --propose", {"done.toml", "the job has passes"});
    check_refused(folder, "passes room.pbrt", {"--propose is required"});
    check_refused(folder, "passes room.pbrt -o room.pbrt --propose", {"expected a name that ends in .toml"});
    folder.write("own.toml", "[scene]\nfile = 'room.pbrt'\n");
    check_refused(folder, "passes own.toml -o own.toml --propose", {"is an input and would be overwritten"});
    check_refused(folder, "passes room.pbrt -o none/p.toml --propose", {"none/p.toml", "No such file"});
    folder.write("saved.toml", "[scene]\nfile = 'room.pbrt'\n[render]\ncheckpoint = '10s'\n");
    check_refused(folder, "passes saved.toml --propose", {"saved.toml", "passes do not support checkpoints"});
}

TEST_CASE("passes --propose gives no class to a method that misses its light", "[passes]") {
    const SceneFolder folder;
    // The lamp is so small that no path finds it through the ball.
    folder.write("lamp.pbrt",
                 "LookAt 0 3 6  0 0 0  0 1 0\nCamera \"perspective\" \"float fov\" 40\n"
                 "Film \"rgb\" \"integer xresolution\" 32 \"integer yresolution\" 24\n"
                 "Sampler \"zsobol\" \"integer pixelsamples\" 16\nWorldBegin\nAttributeBegin\nTranslate 1.5 4 0\n"
                 "AreaLightSource \"diffuse\" \"rgb L\" [1600 1600 1600]\nShape \"sphere\" \"float radius\" 0.05\n"
                 "AttributeEnd\nMaterial \"diffuse\"\n"
                 "Shape \"bilinearmesh\" \"point3 P\" [-5 -1 -5 5 -1 -5 -5 -1 5 5 -1 5]\n"
                 "Material \"dielectric\"\nShape \"sphere\" \"float radius\" 0.9\n");
    const Outcome proposed = run_raylex(folder, "passes lamp.pbrt --propose");
    INFO(proposed.out << proposed.err);
    REQUIRE(proposed.code == 0);
    const std::size_t row = proposed.out.find("# caustics  ");
    REQUIRE(row != std::string::npos);
    std::istringstream words(proposed.out.substr(row));
    std::string mark, name, method;
    words >> mark >> name >> method;
    CHECK((method == "bdpt" || method == "lighttracer"));
}

TEST_CASE("passes --propose gives caustics to the light tracer", "[passes][gate]") {
    const SceneFolder folder;
    const Outcome proposed = run_raylex(
        folder, "passes '" + source_dir() + "/experiments/scenes/glass-caustic/scene.pbrt' --propose --spp 64");
    INFO(proposed.out << proposed.err);
    REQUIRE(proposed.code == 0);
    CHECK(contains(proposed.out, "\nmethod = \"lighttracer\"\n"));
    CHECK(contains(proposed.out, "\ntakes = \"rest\"\n"));
    CHECK(contains(proposed.out, "efficiency relative to bdpt alone"));
}

TEST_CASE("statistics, for which a guided pass has two halves, change no bit of the beauty", "[passes][guide][law2]") {
    const SceneFolder folder;
    folder.write("walls.pbrt", R"(Film "rgb" "integer xresolution" 16 "integer yresolution" 16
LookAt 0 1 3.9  0 1 0  0 1 0
Camera "perspective" "float fov" 39
WorldBegin
AttributeBegin AreaLightSource "diffuse" "rgb L" [9 9 9]
Shape "sphere" "float radius" 0.2 AttributeEnd
Material "diffuse" "rgb reflectance" [0.6 0.6 0.6]
Shape "bilinearmesh" "point3 P" [-1 0 -1 1 0 -1 -1 2 -1 1 2 -1]
Shape "bilinearmesh" "point3 P" [-1 0 -1 -1 0 4 -1 2 -1 -1 2 4]
Shape "bilinearmesh" "point3 P" [1 0 -1 1 0 4 1 2 -1 1 2 4]
)");
    // The length of the training depends on the samples of the whole pass, not of a half.
    const std::string render =
        "render walls.pbrt --spp 64 --pass 'path:C<RD>[LB]:aovs=true' --pass bdpt:rest:guide=on -o ";
    REQUIRE(run_raylex(folder, render + "plain.exr").code == 0);
    REQUIRE(run_raylex(folder, render + "halves.exr --statistics beauty=mse").code == 0);
    auto plain = raylex::display::read_exr(folder.path("plain.exr"));
    auto halves = raylex::display::read_exr(folder.path("halves.exr"));
    REQUIRE((plain && halves));
    CHECK(plane(*plain, "beauty", "G") == plane(*halves, "beauty", "G"));
}

TEST_CASE("a study takes passes as a method", "[passes][gate]") {
    const SceneFolder folder;
    const std::string method =
        "[[method]]\nname = \"passes\"\npasses = [{ method = \"path\", takes = \"rest\" },\n"
        "    { method = \"lighttracer\", takes = \"C<RD>[LB]\", spp = 4 }]\n";
    prepare(folder, experiment_config + method);
    succeed(folder, "experiment run c.toml -o out --report");
    const raylex::experiments::Experiment results = results_of(folder, "out");
    std::size_t cells = 0;
    for (const raylex::experiments::StudyRun& run : results.runs) {
        CHECK_FALSE(run.failed);
        if (run.method != "passes") continue;
        ++cells;
        REQUIRE(run.passes.size() == 2);
        CHECK(run.samples_per_pixel == static_cast<std::uint64_t>(run.budget));
        CHECK(run.passes[0].samples_per_pixel == run.budget);
        CHECK(run.passes[1].samples_per_pixel == 4 * run.budget);
        CHECK(run.passes[1].cpu_seconds > 0);
        CHECK(raylex::experiments::read_mean(run.directory, "pass_lighttracer").ok());
    }
    CHECK(cells == 4);
    const std::string page = folder.read("out/report.html");
    CHECK(contains(page, "<h3>Passes</h3>"));
    CHECK(contains(page, "<td>lighttracer</td>"));
    succeed(folder, "experiment replay c.toml room.passes.4spp.r0 -o out");
    folder.write("c.toml", experiment_config + method + "integrator = \"path\"\n");
    check_refused(folder, "experiment run c.toml -o b", {"c.toml", "an integrator for all paths"});
    folder.write("c.toml", experiment_config + method + "max_dept = 3\n");
    check_refused(folder, "experiment run c.toml -o b", {"c.toml", "max_dept"});
}
