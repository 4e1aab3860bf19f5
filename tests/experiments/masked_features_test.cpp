// Equal bits on other processors. The C library is configured as for an older processor, on which it uses other code
// for sin, exp, pow and the like. Embree queries the processor itself, so only --isa determines its code.
#include <catch2/catch.hpp>

#include <cstdlib>
#include <string>
#include <vector>

#include "display/output/reader/exr_reader.h"
#include "support.h"
#include "tests/support/paths.h"

using namespace raylex::test;

namespace {

/// The features that glibc then does not use: without FMA its double functions have other last bits.
const std::string mask = "GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX512F,-AVX512VL,-AVX2,-AVX,-FMA,-FMA4 ";
/// libjpeg-turbo also queries the processor, and can be configured to use plain code.
const std::string plain_jpeg = "JSIMD_FORCENONE=1 ";

std::string libm_bits(const Folder& folder, const std::string& environment) {
    const Outcome outcome = run_shell(folder, environment + "'" + binary_dir() + "/libm_bits'");
    REQUIRE(outcome.code == 0);
    return outcome.out;
}

/// Glass, rough metal, three coats, an sRGB image in bytes and one of half floats, an image sky, a spot, a sphere and a
/// triangle light, rotations, a lens, and fog with forward scattering.
const std::string world = R"(
MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_a" [0.02 0.03 0.05]
    "rgb sigma_s" [0.05 0.04 0.03] "float g" 0.6
    "rgb Le" [0.01 0.02 0.03]
LookAt 0.3 1.2 -4.1  0 0.4 0  0 1 0
MediumInterface "" "fog"
Camera "perspective" "float fov" 47 "float lensradius" 0.03 "float focaldistance" 3.9
WorldBegin
AttributeBegin
  Rotate 33 1 0.2 0.1
  LightSource "infinite" "string filename" "sky.pfm"
AttributeEnd
LightSource "spot" "blackbody I" 4100 "float power" 30 "point3 from" [1.5 3 -2] "point3 to" [0 0 0] "float coneangle" 37
AttributeBegin
  AreaLightSource "diffuse" "blackbody L" 2900 "float scale" 5
  Translate -1.3 1.9 0.6
  Shape "sphere" "float radius" 0.21
AttributeEnd
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [4 5 6]
  Shape "trianglemesh" "point3 P" [1 2 1  2 2 1  1.4 2.3 0.3] "integer indices" [0 1 2]
AttributeEnd
Texture "bytes" "spectrum" "imagemap" "string filename" "inks.jpg"
Texture "power" "spectrum" "imagemap" "string filename" "inks.jpg" "string encoding" "gamma 2.2"
Texture "halves" "spectrum" "imagemap" "string filename" "rgb_half.exr" "float uscale" 3 "float vscale" 2.7
AttributeBegin
  Material "coateddiffuse" "texture reflectance" "bytes" "float roughness" 0.11 "float thickness" 0.03
      "rgb albedo" [0.4 0.5 0.6] "float g" 0.4
  Shape "bilinearmesh" "point3 P" [-3 0 -3  3 0 -3  -3 0 3  3 0 3]
AttributeEnd
AttributeBegin
  Material "conductor" "spectrum eta" "metal-Cu-eta" "spectrum k" "metal-Cu-k" "float uroughness" 0.05
    "float vroughness" 0.3
  Translate -0.8 0.45 0
  Rotate 71 0.3 1 0.2
  Shape "sphere" "float radius" 0.45 "float phimax" 300
AttributeEnd
AttributeBegin
  Material "dielectric" "spectrum eta" "glass-BK7"
  Translate 0.3 0.5 -0.6
  Shape "sphere" "float radius" 0.4
AttributeEnd
AttributeBegin
  Material "dielectric" "float eta" 1.4 "float roughness" 0.2
  Translate 1 0.5 0.4
  Rotate -80 1 0 0.1
  Shape "cylinder" "float radius" 0.3 "float zmin" -0.4 "float zmax" 0.5
AttributeEnd
AttributeBegin
  Material "diffuse" "texture reflectance" "power"
  Translate -0.2 0.2 -1.3
  Rotate 20 1 1 0
  Shape "disk" "float radius" 0.3 "float innerradius" 0.05
AttributeEnd
AttributeBegin
  Material "coatedconductor" "float conductor.roughness" 0.2 "float interface.roughness" 0.05
  Translate 0.2 0.3 1.2
  Shape "sphere" "float radius" 0.3
AttributeEnd
AttributeBegin
  Material "diffuse" "texture reflectance" "halves"
  Shape "trianglemesh" "point3 P" [-3 0 2  3 0 2  3 3 2  -3 3 2] "integer indices" [0 1 2 0 2 3]
    "point2 uv" [0 0 1 0 1 1 0 1]
AttributeEnd
)";

std::string scene_with(const std::string& filter) {
    return "Film \"rgb\" \"integer xresolution\" 20 \"integer yresolution\" 16\nPixelFilter " + filter + world;
}

/// A square image of floats, as a sky stores radiance on the sphere.
std::string sky() {
    std::string file = "PF\n8 8\n-1.0\n";
    for (int i = 0; i < 8 * 8 * 3; ++i) {
        const float value = 0.02f + 0.3f * static_cast<float>((i * 37) % 61 == 0 ? 20 : (i * 29) % 7) / 7;
        file.append(reinterpret_cast<const char*>(&value), sizeof value);
    }
    return file;
}

/// Returns every value of every layer, with their names.
std::string bits_of(const std::string& path) {
    auto image = raylex::display::read_exr(path);
    INFO((image ? std::string() : image.error().to_string()));
    REQUIRE(image);
    std::string bits;
    for (const auto& layer : image->layers)
        for (const auto& plane : layer.planes) {
            bits += layer.name + "." + plane.name + ":";
            bits.append(reinterpret_cast<const char*>(plane.values.data()), plane.values.size() * sizeof(float));
        }
    return bits;
}

struct MaskedFolder : Folder {
    MaskedFolder() {
        write("sky.pfm", sky());
        for (const char* name : {"inks.jpg", "rgb_half.exr"})
            write(name, read_bytes(source_dir() + "/tests/transport/data/" + name));
    }
    /// Checks that a render has the same bits with and without the mask, and returns them.
    std::string same_bits(const std::string& arguments) const {
        CAPTURE(arguments);
        const std::string line = "\"$RAYLEX\" render scene.pbrt --threads 1 " + arguments;
        const Outcome plain = run_shell(*this, line + " -o plain.exr");
        CAPTURE(plain.err);
        REQUIRE(plain.code == 0);
        const Outcome masked = run_shell(*this, mask + plain_jpeg + line + " -o masked.exr");
        CAPTURE(masked.err);
        REQUIRE(masked.code == 0);
        const std::string bits = bits_of(path("plain.exr"));
        CHECK((bits == bits_of(path("masked.exr"))));
        return bits;
    }
};

const std::string layers =
    " --lpe direct=CDL --lpe glass='C<TS>.*' --aov Nn --aov z --aov P --aov st --aov incidenceAngle "
    "--cryptomatte object --spp 8";

}  // namespace

TEST_CASE("the mask changes results of the C library, but not of raylex's functions", "[isa]") {
    const Folder folder;
    const std::string plain = libm_bits(folder, ""), masked = libm_bits(folder, mask);
    const auto line = [](const std::string& text, const std::string& key) {
        const std::size_t at = text.find(key);
        REQUIRE(at != std::string::npos);
        return text.substr(at, text.find('\n', at) - at);
    };
    CHECK(line(plain, "own") == line(masked, "own"));
    if (line(plain, "fma") == "fma no") {
        WARN("no FMA here, so that masking it shows nothing");
        return;
    }
    CHECK(line(plain, "libm") != line(masked, "libm"));
}

TEST_CASE("images have the same bits under masked processor features", "[isa][gate]") {
    const MaskedFolder folder;
    std::vector<std::string> seen;
    for (const char* integrator : {"path", "bdpt", "lighttracer", "pssmlt"}) {
        folder.write("scene.pbrt", scene_with("\"gaussian\" \"float sigma\" 0.6"));
        seen.push_back(folder.same_bits("--isa sse2 --integrator " + std::string(integrator) + layers));
    }
    for (std::size_t i = 1; i < seen.size(); ++i) CHECK((seen[i] != seen[0]));  // the renders differ
    for (const char* filter : {"\"mitchell\"", "\"sinc\"", "\"blackman-harris\"", "\"triangle\""}) {
        folder.write("scene.pbrt", scene_with(filter));
        folder.same_bits("--isa sse2 --spp 4");
    }
}

TEST_CASE("adaptive and graded renders have the same bits under masked processor features", "[isa]") {
    const MaskedFolder folder;
    folder.write("scene.pbrt", scene_with("\"box\""));
    folder.same_bits("--isa sse2 --until-error 30% --spp 512 --aov sampleCount");
    folder.same_bits(
        "--isa sse2 --spp 4 --display-filter grade:exposure=0.3,gamma='1.7 2.2 0.9',channels=beauty --deep deep.exr");
}
