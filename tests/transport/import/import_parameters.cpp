// Parameters of a scene file: unknown ones are errors, and those that only pbrt reads are warnings; both name the
// position.
#include <catch2/catch.hpp>

#include "tests/transport/import_support.h"

using namespace import_test;

namespace {

struct ParameterCase {
    std::string text;     // the parameter in question is at the start of line 2
    std::string message;  // of the error, or of the one warning
    std::string hint;
};

const std::string triangle_text = "WorldBegin Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0]\n";

const ParameterCase unknown[] = {
    {"Accelerator \"bvh\"\n\"integer maxnodeprim\" 4 WorldBegin", "accelerator 'bvh' has no parameter 'maxnodeprim'",
     "'maxnodeprims'"},
    {"WorldBegin AreaLightSource \"diffuse\"\n\"bool twosides\" true",
     "area light 'diffuse' has no parameter 'twosides'; expected one of: L, scale, filename, power, twosided",
     "did you mean 'twosided'?"},
    {"Camera \"perspective\"\n\"float fovy\" 30 WorldBegin",
     "camera 'perspective' has no parameter 'fovy'; expected one of: fov, lensradius, focaldistance, "
     "frameaspectratio, screenwindow, shutteropen, shutterclose",
     "'fov'"},
    {"Film \"rgb\"\n\"integer xresolutoin\" 30 WorldBegin", "film 'rgb' has no parameter 'xresolutoin'",
     "'xresolution'"},
    {"Film \"rgb\"\n\"integer nbuckets\" 30 WorldBegin", "film 'rgb' has no parameter 'nbuckets'", ""},
    {"Integrator \"path\"\n\"integer maxdpeth\" 3 WorldBegin", "integrator 'path' has no parameter 'maxdpeth'",
     "'maxdepth'"},
    {"Integrator \"bdpt\"\n\"integer chains\" 3 WorldBegin", "integrator 'bdpt' has no parameter 'chains'", ""},
    {"WorldBegin LightSource \"point\"\n\"rgb L\" [1 1 1]",
     "light 'point' has no parameter 'L'; expected one of: I, scale, power, from", ""},
    {"WorldBegin Material \"diffuse\"\n\"rgb reflectence\" [1 1 1]",
     "material 'diffuse' has no parameter 'reflectence'", "'reflectance'"},
    {"WorldBegin MakeNamedMaterial \"a\" \"string type\" \"conductor\"\n\"float rougness\" 1.5",
     "material 'conductor' has no parameter 'rougness'", "'roughness'"},
    {"WorldBegin Material \"raylex:mirror\"\n\"rgb reflectanse\" [1 1 1]",
     "material 'raylex:mirror' has no parameter 'reflectanse'; expected one of: reflectance", "'reflectance'"},
    {"MakeNamedMedium \"fog\" \"string type\" \"homogeneous\"\n\"float sigma\" 1 WorldBegin",
     "medium 'homogeneous' has no parameter 'sigma'", ""},
    {"PixelFilter \"gaussian\"\n\"float alpha\" 2 WorldBegin", "pixel filter 'gaussian' has no parameter 'alpha'", ""},
    {"Sampler \"stratified\"\n\"integer pixelsamples\" 2 WorldBegin",
     "sampler 'stratified' has no parameter 'pixelsamples'; expected one of: xsamples, ysamples, seed, jitter", ""},
    {"WorldBegin Shape \"sphere\"\n\"float raduis\" 3",
     "shape 'sphere' has no parameter 'raduis'; expected one of: radius, zmin, zmax, phimax, alpha",
     "did you mean 'radius'?"},
    {triangle_text + "\"integer indexes\" [0 1 2]", "shape 'trianglemesh' has no parameter 'indexes'", "'indices'"},
    {"WorldBegin Texture \"a\" \"float\" \"checkerboard\"\n\"float uscales\" 3",
     "texture 'checkerboard' has no parameter 'uscales'", "'uscale'"},
    {"WorldBegin Texture \"a\" \"float\" \"scale\"\n\"float uscale\" 3", "texture 'scale' has no parameter 'uscale'",
     "'scale'"},
};

// Each is read by pbrt-v4 and not by raylex; with the value `hint`, ignoring it changes nothing.
const ParameterCase ignored[] = {
    {"Film \"rgb\"\n\"bool savefp16\" true WorldBegin", "parameter 'savefp16' of film 'rgb' is ignored", "false"},
    {"Integrator \"bdpt\"\n\"bool regularize\" true WorldBegin",
     "parameter 'regularize' of integrator 'bdpt' is ignored: specular lobes are never blurred", "false"},
    {"Film \"spectral\"\n\"integer nbuckets\" 30 WorldBegin", "parameter 'nbuckets' of film 'spectral' is ignored", ""},
    {"Integrator \"volpath\"\n\"string lightsampler\" \"exhaustive\" WorldBegin",
     "parameter 'lightsampler' of integrator 'volpath' is ignored: lights are chosen by a tree where there are many",
     "\"bvh\""},
    {"Integrator \"sppm\"\n\"float radius\" 3 WorldBegin", "parameter 'radius' of integrator 'sppm' is ignored", ""},
    {"WorldBegin Material \"diffuse\"\n\"float sigma\" 20", "parameter 'sigma' of material 'diffuse' is ignored", "0"},
    {"WorldBegin Material \"\"\n\"float eta\" 1.5",
     "parameter 'eta' of material 'interface' is ignored: there is no surface", ""},
    {"Sampler \"zsobol\"\n\"string randomization\" \"permutedigits\" WorldBegin",
     "parameter 'randomization' of sampler 'zsobol' is ignored: points are always Owen-scrambled", "\"fastowen\""},
    {"Sampler \"stratified\"\n\"bool jitter\" false WorldBegin",
     "parameter 'jitter' of sampler 'stratified' is ignored", "true"},
    {triangle_text + "\"vector3 S\" [1 0 0 1 0 0 1 0 0]", "parameter 'S' of shape 'trianglemesh' is ignored", ""},
};

}  // namespace

TEST_CASE("a parameter unknown to pbrt-v4 is an error with its position and the closest match", "[law7][import]") {
    for (const ParameterCase& each : unknown) {
        CAPTURE(each.text);
        const raylex::Error error = error_of(each.text);
        CHECK(error.file == "test.pbrt");
        CHECK(error.line == 2);
        CHECK(error.column == 1);
        CHECK(contains(error.message, each.message));
        CHECK(contains(error.hint, each.hint));
        CHECK(error.excerpt == each.text.substr(each.text.find('\n') + 1));
    }
}

TEST_CASE("a parameter that only pbrt-v4 reads is one warning, and none if ignoring its value changes nothing",
          "[law7][import]") {
    for (const ParameterCase& each : ignored) {
        CAPTURE(each.text);
        const auto scene = scene_of(each.text);
        REQUIRE(scene.warnings.size() == 1);
        CHECK(contains(scene.warnings[0].message, each.message));
        CHECK(scene.warnings[0].file == "test.pbrt");
        CHECK(scene.warnings[0].line == 2);
        CHECK(scene.warnings[0].column == 1);
        if (each.hint.empty()) continue;
        const std::size_t value = each.text.find_first_of(' ', each.text.find('"', each.text.find('\n') + 2) + 1);
        const std::size_t end = each.text.find(" WorldBegin", value);
        const std::string rest = end == std::string::npos ? std::string() : each.text.substr(end);
        CHECK(scene_of(each.text.substr(0, value + 1) + each.hint + rest).warnings.empty());
    }
    // Once for a type in any number of directives; another type gives another warning.
    const std::string lit = "\"vector3 S\" [1 0 0 1 0 0 1 0 0]\n", again = triangle_text.substr(11) + lit;
    CHECK(scene_of(triangle_text + lit + again + again).warnings.size() == 1);
    CHECK(scene_of("Film \"rgb\" \"bool savefp16\" true\n" + triangle_text + lit).warnings.size() == 2);
}

TEST_CASE("an image's filters are read without a warning", "[import]") {
    const Folder folder;
    folder.write("a.png", "");  // not read by the import
    for (const char* filter : {"bilinear", "point", "trilinear", "EWA", "unfiltered"}) {
        const auto scene = raylex::transport::import_pbrt(folder.write(
            "a.pbrt", std::string("WorldBegin Texture \"a\" \"float\" \"imagemap\" \"string filename\" \"a.png\" "
                                  "\"float maxanisotropy\" 4\n\"string filter\" \"") +
                          filter + "\""));
        if (!scene) FAIL(scene.error().to_string());
        CHECK(scene->warnings.empty());
    }
}

TEST_CASE("parameters from Attribute may be unknown to a type, as in pbrt", "[import]") {
    const auto scene = scene_of(
        "WorldBegin Attribute \"shape\" \"float radius\" 3 Attribute \"material\" \"float roughness\" 0.5\n"
        "Attribute \"light\" \"float coneangle\" 20 Material \"diffuse\" LightSource \"point\"\n"
        "Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0] Shape \"sphere\"");
    CHECK(scene.warnings.empty());
    REQUIRE(scene.shapes.size() == 2);
    CHECK(scene.shapes[1].radius == 3);
    REQUIRE(scene.lights.size() == 1);
    CHECK(scene.lights[0].parameters.unused().empty());  // no later warning either
}

TEST_CASE("the scenes that come with raylex contain no unused parameters", "[import]") {
    std::size_t count = 0;
    for (const auto& entry : fs::directory_iterator(fs::path(raylex::test::source_dir()) / "experiments/scenes")) {
        const fs::path file = entry.path() / "scene.pbrt";
        if (!fs::exists(file)) continue;
        CAPTURE(file.string());
        const auto scene = raylex::transport::import_pbrt(file.string());
        if (!scene) FAIL(scene.error().to_string());
        for (const raylex::Error& warning : scene->warnings) {
            CAPTURE(warning.to_string());
            CHECK_FALSE(contains(warning.message, "is ignored"));
        }
        ++count;
    }
    CHECK(count >= 11);
}

TEST_CASE("parameters that pbrt-v4 reads and does not use give no warning", "[import]") {
    CHECK(scene_of("Camera \"spherical\" \"float lensradius\" 1 \"float focaldistance\" 2 \"float frameaspectratio\" 1 "
                   "\"float screenwindow\" [-1 1 -1 1] WorldBegin")
              .warnings.empty());
}
