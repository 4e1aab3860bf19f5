// Sample and display filters by flag and by job, and their effect on partitions.
#include <catch2/catch.hpp>

#include "display/output/reader/exr_reader.h"
#include "display/output/writer/deep_file.h"
#include "support.h"

using namespace raylex::test;
using raylex::display::read_exr;

namespace {

std::vector<float> plane(const Folder& folder, const std::string& file, const std::string& layer,
                         const std::string& name) {
    auto image = read_exr(folder.path(file));
    REQUIRE(image);
    return raylex::test::plane(*image, layer, name);
}

/// Runs a render with `arguments` that must be refused.
void check_render_refused(const Folder& folder, const std::string& arguments, const std::vector<std::string>& words) {
    check_refused(folder, arguments + " -o refused.exr", words);
}

/// A point light, a plate below it, and the ground with the plate's shadow.
const char* shadow_scene = R"(Film "rgb" "integer xresolution" 32 "integer yresolution" 32
PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
Sampler "independent" "integer pixelsamples" 4
Integrator "path" "integer maxdepth" 2
LookAt 0 6 0.001  0 0 0  0 0 -1
Camera "perspective" "float fov" 40
WorldBegin
LightSource "point" "rgb I" [30 30 30] "point3 from" [0 2 0]
MakeNamedMaterial "ground" "string type" "diffuse" "rgb reflectance" [.5 .4 .3]
NamedMaterial "ground"
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-9 0 9 9 0 9 9 0 -9 -9 0 -9]
MakeNamedMaterial "plate" "string type" "diffuse" "rgb reflectance" [.2 .2 .2]
NamedMaterial "plate"
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-.4 1 .4 .4 1 .4 .4 1 -.4 -.4 1 -.4]
)";

}  // namespace

TEST_CASE("sample filters apply in the order of job and flags, and splits still sum", "[filters][law1]") {
    const SceneFolder folder;
    folder.write("job.toml",
                 "[scene]\nfile = \"room.pbrt\"\n[[channel]]\nname = \"direct\"\nlpe = \"CDL\"\n"
                 "[[sample_filter]]\ntype = \"clamp\"\nluminance = 0.05\n"
                 "[[sample_filter]]\ntype = \"grade\"\nexposure = 1\nsaturation = 0.5\n");
    REQUIRE(run_raylex(folder, "render job.toml -o job.exr --threads 1").code == 0);
    REQUIRE(
        run_raylex(folder,
                   "render room.pbrt -o flags.exr --threads 3 --lpe direct=CDL --sample-filter clamp:luminance=0.05 "
                   "--sample-filter grade:exposure=1,saturation=0.5")
            .code == 0);
    REQUIRE(run_raylex(folder,
                       "render room.pbrt -o other.exr --lpe direct=CDL "
                       "--sample-filter grade:exposure=1,saturation=0.5 --sample-filter clamp:luminance=0.05")
                .code == 0);
    CHECK(plane(folder, "job.exr", "beauty", "G") == plane(folder, "flags.exr", "beauty", "G"));
    CHECK(plane(folder, "other.exr", "beauty", "G") != plane(folder, "flags.exr", "beauty", "G"));
    auto image = read_exr(folder.path("job.exr"));
    CHECK(image->attributes["verdict/auto"].starts_with("holds; "));
    CHECK(run_raylex(folder, "verify job.exr").code == 0);

    folder.write("old.toml", "[scene]\nfile = \"room.pbrt\"\n[sample_filter]\ntype = \"clamp\"\n");
    check_render_refused(folder, "render old.toml", {"old.toml:3", "[[sample_filter]]"});
    folder.write("slip.toml", "[scene]\nfile = \"room.pbrt\"\n[[sample_filter]]\ntype = \"clamp\"\nluminence = 3\n");
    check_render_refused(folder, "render slip.toml", {"slip.toml:5", "did you mean 'luminance'"});
    check_render_refused(folder, "render room.pbrt --sample-filter clmp", {"--sample-filter", "did you mean 'clamp'"});
    check_render_refused(folder, "render room.pbrt --sample-filter grade:offset=1", {"no longer sum"});
}

TEST_CASE("the sample filter 'none' works with every integrator", "[filters]") {
    const SceneFolder folder;
    for (const char* integrator : {"path", "lighttracer", "pssmlt"}) {
        CAPTURE(integrator);
        const std::string render = std::string("render room.pbrt --spp 1 --integrator ") + integrator;
        const Outcome outcome = run_raylex(folder, render + " --sample-filter none -o with.exr");
        INFO(outcome.err);
        CHECK(outcome.code == 0);
        REQUIRE(run_raylex(folder, render + " -o without.exr").code == 0);
        CHECK(plane(folder, "with.exr", "beauty", "G") == plane(folder, "without.exr", "beauty", "G"));
    }
    check_render_refused(folder, "render room.pbrt --integrator lighttracer --sample-filter none --sample-filter clamp",
                         {"supports no sample filters ('clamp')"});
}

TEST_CASE("a filter that changes one layer of a partition removes the partition, with a warning", "[filters][law1]") {
    const SceneFolder folder;
    const Outcome outcome = run_raylex(
        folder,
        "render room.pbrt -o a.exr --lpe direct=CDL --sample-filter grade:channels=direct,gain=2 --light-groups");
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    CHECK(outcome.err.find("partition 'auto' is left out of the file: a filter changes 'direct'") != std::string::npos);
    auto image = read_exr(folder.path("a.exr"));
    REQUIRE(image);
    REQUIRE(image->partitions.size() == 1);  // the partition that the filter does not change still holds
    CHECK(image->partitions[0].name == "light_groups");
    REQUIRE(run_raylex(folder, "render room.pbrt -o b.exr --lpe direct=CDL").code == 0);
    const std::vector<float> graded = plane(folder, "a.exr", "direct", "R"),
                             plain = plane(folder, "b.exr", "direct", "R");
    for (std::size_t i = 0; i < plain.size(); ++i) CHECK(graded[i] == 2 * plain[i]);
    CHECK(plane(folder, "a.exr", "beauty", "R") == plane(folder, "b.exr", "beauty", "R"));
}

TEST_CASE("display filters change files and viewers, but not deep images or statistics", "[filters]") {
    const SceneFolder folder;
    REQUIRE(run_raylex(folder,
                       "render room.pbrt -o plain.exr --deep plain.deep.exr --statistics beauty=mse --lpe direct=CDL")
                .code == 0);
    const Outcome outcome = run_raylex(folder,
                                       "render room.pbrt -o a.exr --deep a.deep.exr --statistics beauty=mse --lpe "
                                       "direct=CDL --display-filter grade:exposure=1 "
                                       "--display-filter background:color='0.5 0.25 1' --preview a.png");
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    CHECK(outcome.err.find("partition 'auto' is left out of the file: a filter changes 'beauty'") != std::string::npos);
    CHECK(outcome.err.find("the deep image is not compared") != std::string::npos);
    const std::vector<float> before = plane(folder, "plain.exr", "beauty", "R"),
                             alpha = plane(folder, "plain.exr", "beauty", "A"),
                             after = plane(folder, "a.exr", "beauty", "R");
    for (std::size_t i = 0; i < before.size(); ++i)
        CHECK(after[i] == Approx(2 * before[i] + (1 - alpha[i]) * 0.5f).epsilon(1e-6));
    for (const float a : plane(folder, "a.exr", "beauty", "A")) CHECK(a == 1);
    CHECK(plane(folder, "a.exr", "beauty_mse", "R") == plane(folder, "plain.exr", "beauty_mse", "R"));
    const auto flattened = raylex::display::check_deep(folder.path("a.deep.exr"), *read_exr(folder.path("plain.exr")));
    REQUIRE(flattened);
    CHECK(flattened->holds);

    // Linear, and applied to all light: the partition stays and holds.
    folder.write("job.toml",
                 "[scene]\nfile = \"room.pbrt\"\n[[channel]]\nname = \"direct\"\nlpe = \"CDL\"\n"
                 "[[display_filter]]\ntype = \"grade\"\ngain = [0.5, 1.0, 2.0]\n");
    REQUIRE(run_raylex(folder, "render job.toml -o b.exr").code == 0);
    CHECK(run_raylex(folder, "verify b.exr").code == 0);
    auto image = read_exr(folder.path("b.exr"));
    REQUIRE(image->partitions.size() == 1);
    const std::vector<float> blue = plane(folder, "b.exr", "direct", "B"),
                             plain = plane(folder, "plain.exr", "direct", "B");
    for (std::size_t i = 0; i < plain.size(); ++i) CHECK(blue[i] == 2 * plain[i]);
    check_render_refused(folder, "render room.pbrt --display-filter bakground",
                         {"--display-filter", "did you mean 'background'"});
    check_render_refused(folder, "render room.pbrt --lpe direct=CDL --no-beauty --display-filter background",
                         {"expected a beauty"});
}

TEST_CASE("a holdout's shadow goes into alpha and a layer", "[filters]") {
    const Folder folder;
    folder.write("plate.pbrt", shadow_scene);
    const std::string job =
        "[scene]\nfile = \"plate.pbrt\"\n[[label]]\nmaterial = \"ground\"\nholdout = true\n"
        "[[channel]]\nname = \"unoccluded\"\nlpe = \"holdouts;unoccluded;C[DS]+<L.>\"\n";
    const std::string held = "[[channel]]\nname = \"shadows\"\nlpe = \"holdouts;shadows;C[DS]+<L.>\"\n",
                      arriving = "[[channel]]\nname = \"occluded\"\nlpe = \"holdouts;C[DS]+<L.>\"\n";
    const std::string filter =
        "[[sample_filter]]\ntype = \"shadow\"\nunoccluded = \"unoccluded\"\nchannel = \"shadow\"\n";
    folder.write("held.toml", job + held + filter + "shadows = \"shadows\"\n");
    folder.write("pair.toml", job + arriving + filter + "occluded = \"occluded\"\n");
    folder.write("none.toml", job + held);
    for (const char* name : {"held", "pair", "none"}) {
        const Outcome outcome = run_raylex(folder, std::string("render ") + name + ".toml -o " + name + ".exr");
        CAPTURE(name, outcome.err);
        REQUIRE(outcome.code == 0);
    }
    // A point light is found only by light sampling, so the two ways give the same ratio.
    const std::vector<float> shadow = plane(folder, "held.exr", "shadow", "shadow"),
                             alpha = plane(folder, "held.exr", "beauty", "A"),
                             plate = plane(folder, "none.exr", "beauty", "A");
    const std::vector<float> pair = plane(folder, "pair.exr", "shadow", "shadow");
    int dark = 0, lit = 0;
    for (std::size_t i = 0; i < shadow.size(); ++i) {
        CHECK(pair[i] == Approx(shadow[i]).margin(1e-6));
        CHECK(alpha[i] == Approx(plate[i] + shadow[i]).margin(1e-6));  // the plate itself is not a holdout, and opaque
        dark += shadow[i] == 1;
        lit += shadow[i] == 0 && plate[i] == 0;
    }
    // The plate hides 0.96 x 0.96 of the ground; its shadow is 1.6 x 1.6, and a pixel is 0.14 wide.
    CHECK(dark > 10);
    CHECK(lit > 500);
    folder.write("taken.toml", job + held + filter + "shadows = \"shadows\"\n" + filter + "shadows = \"shadows\"\n");
    check_render_refused(folder, "render taken.toml", {"whose name is taken"});
}

TEST_CASE("filter mode splat by flag and job; its limitations are named", "[splat]") {
    const SceneFolder folder;
    REQUIRE(run_raylex(folder, "render room.pbrt -o flag.exr --filter-mode splat --threads 1 --lpe direct=CDL --aov z")
                .code == 0);
    folder.write(
        "job.toml",
        "[scene]\nfile = \"room.pbrt\"\n[render]\nfilter_mode = \"splat\"\nthreads = 3\n[channels]\naovs = [\"z\"]\n"
        "[[channel]]\nname = \"direct\"\nlpe = \"CDL\"\n");
    REQUIRE(run_raylex(folder, "render job.toml -o job.exr").code == 0);
    CHECK(plane(folder, "flag.exr", "beauty", "R") == plane(folder, "job.exr", "beauty", "R"));
    auto image = read_exr(folder.path("job.exr"));
    CHECK(image->attributes["raylex/filter_mode"] == "splat");
    CHECK(image->attributes["verdict/auto"].starts_with("holds; "));
    CHECK(run_raylex(folder, "verify job.exr").code == 0);
    check_render_refused(folder, "render room.pbrt --filter-mode splat --statistics beauty=mse",
                         {"--statistics", "filter mode splat"});
    check_render_refused(folder, "render room.pbrt --filter-mode splat --deep d.exr",
                         {"--deep", "filter mode importance"});
    check_render_refused(folder, "render room.pbrt --filter-mode splat --cryptomatte object", {"cryptomatte"});
    check_render_refused(folder, "render room.pbrt --filter-mode spalt", {"--filter-mode"});
    folder.write("bad.toml", "[scene]\nfile = \"room.pbrt\"\n[render]\nfilter_mode = \"spalt\"\n");
    check_render_refused(folder, "render bad.toml", {"bad.toml:4", "expected \"importance\" or \"splat\""});
}

TEST_CASE("the film's maxcomponentvalue clamps samples, unless the job has filters of its own", "[filters]") {
    const Folder folder;
    folder.write("lamp.pbrt", R"(LookAt 0 0 5  0 0 0  0 1 0
Camera "perspective" "float fov" 10
Film "rgb" "integer xresolution" 8 "integer yresolution" 8 "float maxcomponentvalue" 2
WorldBegin
AreaLightSource "diffuse" "rgb L" [10 5 1]
Shape "sphere")");
    const auto centre = [&](const std::string& options) {
        const Outcome outcome = run_raylex(folder, "render lamp.pbrt -o lamp.exr --spp 1 " + options);
        INFO(outcome.out << outcome.err);
        REQUIRE(outcome.code == 0);
        std::vector<float> rgb;
        for (const char* name : {"R", "G", "B"}) rgb.push_back(plane(folder, "lamp.exr", "beauty", name)[8 * 4 + 4]);
        return std::pair(rgb, outcome.err);
    };
    const std::vector<float> clamped = centre("").first, free = centre("--sample-filter none").first;
    // In XYZ, as in pbrt: X is the largest, by the matrix of IEC 61966-2-1, whose digits are accurate to 2e-4.
    const double x = 0.4124 * 10 + 0.3576 * 5 + 0.1805 * 1;
    for (std::size_t c = 0; c < 3; ++c) CHECK(clamped[c] == Approx(free[c] * 2 / x).epsilon(3e-4));
    const auto [splatted, said] = centre("--integrator lighttracer");
    CHECK(splatted[0] == Approx(free[0]));
    CHECK(contains(said, "the film's maxcomponentvalue is ignored: splatted light has no samples"));
    const auto [both, nothing_said] = centre("--integrator bdpt");
    CHECK(both[0] == clamped[0]);
    CHECK_FALSE(contains(nothing_said, "maxcomponentvalue"));

    // Each splat is bounded separately. With one scattering event there is at most one splat per light path, so an
    // image's mean is at most the limit for samples plus the limit for splats.
    folder.write("floor.pbrt", R"(LookAt 0 2 2  0 0 0  0 1 0
Camera "perspective" "float fov" 40
Film "rgb" "integer xresolution" 8 "integer yresolution" 8 "float maxcomponentvalue" 0.001
Integrator "bdpt" "integer maxdepth" 1
WorldBegin
LightSource "point" "point3 from" [0 1 0] "rgb I" [1 1 1]
Shape "disk" "float radius" 3
AttributeBegin Rotate -90 1 0 0 Shape "disk" "float radius" 3 AttributeEnd)");
    const auto mean = [&](const std::string& options) {
        const Outcome outcome = run_raylex(folder, "render floor.pbrt -o floor.exr --spp 16 " + options);
        INFO(outcome.out << outcome.err);
        REQUIRE(outcome.code == 0);
        double sum = 0;
        for (const float value : plane(folder, "floor.exr", "beauty", "G")) sum += value / 64.0;
        return sum;
    };
    // For white light Y equals G; the filter's noise of 64 pixels with 16 splats each moves the mean by at most a
    // tenth.
    CHECK(mean("") < 1.1 * 0.002);
    CHECK(mean("--sample-filter none") > 0.02);
}
