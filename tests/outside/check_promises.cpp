// The promises of the display services to plugins from outside, each through the installed program.
#include <algorithm>
#include <cmath>

#include "check.h"

namespace {

const std::string with = plugin("promises") + "scene.pbrt --spp 16 ";

bool is_all(const std::vector<float>& values, float expected) {
    return values.size() == 256 && std::all_of(values.begin(), values.end(), [&](float v) { return v == expected; });
}
/// Alpha of a layer within a rounding to float.
bool is_near(const std::vector<float>& values, float expected) {
    return values.size() == 256 &&
           std::all_of(values.begin(), values.end(), [&](float v) { return std::abs(v - expected) <= 1e-6f; });
}

void scene_with(const std::string& mode, const std::string& world) {
    write_scene("Integrator \"promises\" \"string mode\" \"" + mode + "\"\n", world);
}

void check_discard() {
    scene_with("raster", wall);
    // Half of the 4 iterations of 16 samples are discarded, by a call before or after 2,560 splats; what is left is 1.
    const std::vector<float> seen = render(plugin("promises") + "scene.pbrt --spp 64 --stats stats.json");
    double mean = 0;
    for (const float each : seen) mean += static_cast<double>(each) / 256;
    // Splats of neighbours reach a pixel through the box filter of half a pixel: a pixel has as many as it has samples.
    check(seen.size() == 256 && std::abs(mean - 1) < 1e-5,
          "discard_iteration() drops splats at raster positions: mean " + std::to_string(mean));
    check(read("stats.json").find("\"camera\": 8192") != std::string::npos,
          "discarded iterations are in no count of samples");
    scene_with("raster_all", wall);
    check(run("render " + plugin("promises") + "scene.pbrt --spp 32 -o none.exr") == 2 &&
              read("err.txt").find("discarded all") != std::string::npos,
          "a render whose iterations were all discarded ends with a message");
}

void check_channels() {
    scene_with("flat", wall);
    const std::string declared =
        "--channel heat:float --channel spots:rgb --channel where:point --channel number:integer ";
    for (const std::string beauty : {"", "--no-beauty "}) {
        check(is_all(render(with + declared + beauty, "heat"), 0.75f), "a job declares a channel of numbers " + beauty);
        check(is_all(read_layer("spots"), 1) && is_all(read_layer("where"), 4), "and of colours and points");
        check(is_all(read_layer("number"), 7), "and of integers");
        const std::string errors = read("err.txt");
        check(errors.find("refused") == std::string::npos && errors.find("rejected") == std::string::npos,
              "a channel that nobody requested refuses nothing");
    }
    write("job.toml",
          "plugins = ['" OUTSIDE_PLUGINS
          "/libpromises.so']\n[scene]\nfile = \"scene.pbrt\"\n[[channel]]\nname = \"heat\"\ntype = \"float\"\n"
          "rule = \"max\"\n");
    check(is_all(render("job.toml --spp 16", "heat"), 0.75f), "[[channel]] with a type and no expression");
    render(with + "--channel typo:float", "typo");
    check(read("err.txt").find("'typo' is empty") != std::string::npos,
          "a declared channel that nobody fills is named");
    check(run("render " + with + "--channel heat:flaot -o out.exr") == 2 &&
              read("err.txt").find("did you mean 'float'?") != std::string::npos,
          "an unknown type is refused with the near miss");
}

void check_rows() {
    const std::string layers =
        "--channel N:normal --channel depth_of:float --aov a --deep deep.exr --deep-channels N,depth_of ";
    for (const std::string mode : {"stack", "stack_first"}) {
        scene_with(mode, wall);
        const std::vector<float> depth = render(with + layers, "depth_of"), alpha = read_layer("a");
        check(is_near(alpha, 0.875f), mode + ": three surfaces of opacity 0.5 have alpha 0.875");
        // Weights 4 : 2 : 1 of depths 2, 3 and 4, or the first alone.
        const float mean = mode == "stack" ? (4 * 2 + 2 * 3 + 4) / 7.0f : 2.0f;
        check(is_near(depth, 0.875f * mean),
              mode + ": a written value divided by alpha is the mean of what was written");
        // A deep image that does not flatten to the image ends a render with exit code 1.
        check(depth.size() == 256, mode + ": the deep image flattens to the same");
    }
}

void check_supplied() {
    const std::string aovs = "--aov Nn,id,albedo,z,a ";
    write_scene("", "Material \"diffuse\"\n" + wall);
    const std::vector<float> z = render("scene.pbrt --spp 16 " + aovs, "z"), id = read_layer("id"),
                             albedo = read_layer("albedo"), normal = read_layer("Nn"), alpha = read_layer("a");
    scene_with("flat", "Material \"diffuse\"\n" + wall);
    check(render(with + aovs, "z") == z && read_layer("id") == id && read_layer("albedo") == albedo &&
              read_layer("Nn") == normal && read_layer("a") == alpha,
          "an integrator without geometry has the depth, alpha and AOVs of `path`, bit by bit");
    scene_with("flat", "Material \"diffuse\"\nShape \"disk\" \"float alpha\" 0.5\n");
    run("render " + with + "-o out.exr");
    check(read("err.txt").find("cutouts") != std::string::npos,
          "cutouts that an integrator does not declare are named");
}

void check_vertices() {
    write_scene("Integrator \"path\" \"integer maxdepth\" 2\n",
                "Texture \"d\" \"spectrum\" \"depths\" \"rgb input\" [.5 .25 .125] \"string channel\" \"paint\"\n"
                "Material \"diffuse\" \"texture reflectance\" \"d\"\n" +
                    wall +
                    "Translate 0 0 1 Rotate 180 0 1 0 Shape \"disk\" \"float radius\" 500 \"float innerradius\" 1.2\n");
    check(is_near(render(with + "--aov paint", "paint"), 0.5f),
          "a plugin's pattern writes to a channel that a texture names");
    const std::vector<float> deeper = render(with + "--aov deeper_look_ups", "deeper_look_ups");
    check(deeper.size() == 256 && deeper[pixel(8, 8)] > 0.1f, "patterns have the services at every vertex");
    write_scene("Integrator \"path\" \"integer maxdepth\" 2\n", "Material \"marker\"\n" + wall);
    check(is_near(render(with + "--aov depths_met", "depths_met"), 1),
          "materials have the services and the path's depth");
    check(is_near(render(with + "--aov depths_met --no-beauty", "depths_met"), 1), "without a beauty, too");
    check(is_near(render(with + "--sample-filter three", "three"), 3), "what a sample filter edits counts as sent");
    check(run("plugins '" OUTSIDE_PLUGINS "/libpromises.so'") == 0 &&
              read("out.txt").find("channel depths_met") != std::string::npos,
          "`raylex plugins` lists the channels that a plugin declares");
}

void check_new() {
    for (const std::string name : {"tracer", "stripes", "minnaert", "exposure", "pfm"}) {
        const std::string test = "bash '" OUTSIDE_NEW "/" + name +
                                 "/test.sh' '" OUTSIDE_RAYLEX "' '" OUTSIDE_PLUGINS "/lib" + name +
                                 ".so' >new.txt 2>&1";
        const bool passes = std::system(test.c_str()) == 0;
        check(passes, "raylex new plugin " + name + ": its own test passes" + (passes ? "" : ": " + read("new.txt")));
    }
    const std::string folder = "'" OUTSIDE_NEW "/pfm";
    const bool builds = std::system(("cmake -G Ninja -DCMAKE_PREFIX_PATH='" OUTSIDE_PREFIX_PATH "' -S " + folder +
                                     "' -B " + folder + "/build' >new.txt 2>&1 && cmake --build " + folder +
                                     "/build' >>new.txt 2>&1 && ctest --test-dir " + folder + "/build' >>new.txt 2>&1")
                                        .c_str()) == 0;
    check(builds,
          "raylex new plugin: the project builds and passes by itself" + (builds ? "" : ": " + read("new.txt")));
    check(run("new plugin Bad-Name") == 2 && run("new plugin pfm -o '" OUTSIDE_NEW "/pfm'") == 2,
          "a bad name and a folder that exists are refused");
}

}  // namespace

void check_promises() {
    check_discard();
    check_channels();
    check_rows();
    check_supplied();
    check_vertices();
    check_new();
}
