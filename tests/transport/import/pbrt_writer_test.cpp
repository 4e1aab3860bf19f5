// Scenes that are written and read again have the same content to the bit, and so the same images.
#include <catch2/catch.hpp>

#include <bit>
#include <cmath>
#include <cstdlib>

#include "transport/import/pbrt/pbrt_values.h"
#include "transport/import/pbrt/pbrt_writer.h"
#include "transport/import_support.h"
#include "transport/render/render.h"
#include "transport/scene/scene_hash.h"

using namespace import_test;
using namespace raylex::transport;

namespace {

SceneDescription scene_in_file(const std::string& path) {
    auto scene = import_pbrt(path);
    if (!scene) FAIL(scene.error().to_string());
    return std::move(*scene);
}

/// Writes the scene and reads it again.
SceneDescription again(const SceneDescription& scene, const Folder& folder) {
    const auto written = write_pbrt(scene, folder.path("again.pbrt"));
    if (!written) FAIL(written.error().to_string());
    CHECK(written->empty());
    return scene_in_file(folder.path("again.pbrt"));
}

std::vector<double> image_of(const SceneDescription& scene) {
    RenderSettings settings;
    settings.samples.per_pixel = 2;
    settings.film.resolution = std::array<int, 2>{24, 16};
    settings.machine.threads = 1;
    auto output = render(scene, settings);
    if (!output) FAIL(output.error().to_string());
    return output->frame_buffer.resolve(output->beauty);
}

}  // namespace

TEST_CASE("pbrt writer: the project's scenes are read unchanged", "[pbrt-writer]") {
    const Folder folder;
    std::size_t scenes = 0;
    for (const auto& entry : fs::directory_iterator(fs::path(raylex::test::source_dir()) / "experiments/scenes")) {
        const fs::path file = entry.path() / "scene.pbrt";
        if (!fs::exists(file)) continue;
        INFO(file.string());
        ++scenes;
        const SceneDescription scene = scene_in_file(file.string());
        const SceneDescription twin = again(scene, folder);
        CHECK(scene_hash(twin) == scene_hash(scene));
        CHECK((image_of(twin) == image_of(scene)));
    }
    CHECK(scenes >= 14);
}

TEST_CASE("pbrt writer: features that files can express", "[pbrt-writer]") {
    const Folder folder;
    const auto path = folder.write("two faces.ply",
                                   "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n"
                                   "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
                                   "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
                                   "0 0 0 0 0 1\n1 0 0 0 0 1\n1 1 0 0 0 1\n0 1 0 0 0 1\n0.5 2 0.1 0 1 1\n"
                                   "4 0 1 2 3\n3 2 3 4\n");
    const SceneDescription scene = scene_of(R"(
        ColorSpace "rec2020"
        Film "rgb" "integer xresolution" 8 "integer yresolution" 6
        MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_s" [0.1 0.2 0.3]
        MakeNamedMedium "ink" "string type" "homogeneous" "rgb sigma_a" [0.1 0.2 0.3]
        MediumInterface "" "fog"
        Rotate 30 1 2 3
        Scale 1 1 -2
        LookAt 1e6 0.1 4  1e6 0 0  0 1 0.3
        Camera "perspective" "float fov" 40
        WorldBegin
        Attribute "material" "float roughness" 0.25
        Shape "sphere" "float radius" 0.1
        Material "conductor" "spectrum eta" "metal-Cu-eta"
        Rotate 12 0.1 0.2 0.3
        Translate 1e-30 1e10 0.1
        Texture "mask" "float" "checkerboard" "string mapping" "planar"
        Shape "disk" "texture alpha" "mask" "float phimax" 270 "float innerradius" 0.33333333
        AttributeBegin
          Material "diffuse" "rgb reflectance" [0.1 0.7 0.3]
          AreaLightSource "diffuse" "blackbody L" 3200 "bool twosided" true
          Shape "cylinder" "float zmin" -0.7 "float alpha" 0.125
          ReverseOrientation
          Scale 1 -1.1 1
          Shape "trianglemesh" "point3 P" [0 0 0 1e-20 1 0 3.1e8 1 1.1] "normal N" [0 0 1 0 1 1 0.3 0.1 1]
                "point2 uv" [0 0 0.1 1 1 0.3] "integer indices" [0 1 2]
          MediumInterface "ink" "fog"
          Shape "bilinearmesh" "point3 P" [0 0 0 1 0 0 0 1 0 1 1 0.5]
        AttributeEnd
        Shape "sphere" "float zmax" 0.5
        AttributeBegin
          MediumInterface "" ""
          Shape "plymesh" "string filename" "two faces.ply"
        AttributeEnd
        ObjectBegin "thing \"x\""
          Material "dielectric" "float eta" 1.33
          Translate 0 0 1
          Shape "sphere"
          NamedMaterial "late"
          Shape "disk"
        ObjectEnd
        ObjectInstance "thing \"x\""
        Rotate 77 1 1 1
        ObjectInstance "thing \"x\""
        MakeNamedMaterial "late" "string type" "coateddiffuse"
        LightSource "spot" "rgb I" [1 2 3] "point3 from" [0 1 2] "float coneangle" 12.5
    )",
                                            folder.path("scene.pbrt"));
    const SceneDescription twin = again(scene, folder);
    CHECK(scene_hash(twin) == scene_hash(scene));
    CHECK((image_of(twin) == image_of(scene)));
    // A scene read from a written file is written as the same text.
    CHECK((pbrt_text(twin).text == pbrt_text(scene).text));
}

TEST_CASE("pbrt writer: entities that blocks cannot share are written again, for the same image", "[pbrt-writer]") {
    const Folder folder;
    SceneDescription scene = scene_of(R"(
        Film "rgb" "integer xresolution" 8 "integer yresolution" 6
        LookAt 0 0 4  0 0 0  0 1 0
        Camera "perspective"
        WorldBegin
        AttributeBegin AreaLightSource "diffuse" Material "diffuse" Translate -1 0 0 Shape "sphere" AttributeEnd
        AttributeBegin AreaLightSource "diffuse" Material "conductor" Translate 1 0 0 Shape "sphere" AttributeEnd
        AttributeBegin Translate 0 1 0 Shape "sphere" AttributeEnd
        AttributeBegin Translate 0 -1 0 Shape "sphere" AttributeEnd
    )");
    REQUIRE(scene.shapes.size() == 4);
    for (const std::size_t i : {2U, 3U}) {  // a b a b, and lights in the opposite order
        scene.shapes[i].material = scene.shapes[i - 2].material;
        scene.shapes[i].area_light = scene.shapes[3 - i].area_light;
    }
    const SceneDescription twin = again(scene, folder);
    CHECK(twin.materials.size() > scene.materials.size());
    CHECK((image_of(twin) == image_of(scene)));
}

TEST_CASE("pbrt writer: numbers are read back exactly", "[pbrt-writer]") {
    std::uint64_t state = 5;
    for (int i = 0; i < 200000; ++i) {
        state = state * 6364136223846793005ull + 1442695040888963407ull;
        const auto bits = static_cast<std::uint32_t>(state >> 32);
        const float value = std::bit_cast<float>(bits);
        if (!std::isfinite(value)) continue;
        std::string text;
        append_number(text, value);
        CHECK(static_cast<float>(std::strtod(text.c_str(), nullptr)) == value);
    }
}

TEST_CASE("pbrt writer: settings of cameras and films are kept in scenes without them", "[pbrt-writer]") {
    const Folder folder;
    const auto comes_back = [&](const std::string& text) {
        folder.write("scene.pbrt", text);
        const SceneDescription scene = scene_in_file(folder.path("scene.pbrt"));
        const SceneDescription twin = again(scene, folder);
        CHECK(scene_hash(twin) == scene_hash(scene));
        CHECK(twin.transform_times == scene.transform_times);
        CHECK(twin.color.scene_space == scene.color.scene_space);
        CHECK((image_of(twin) == image_of(scene)));
    };
    comes_back(R"(TransformTimes 0 4
        WorldBegin
        LightSource "infinite"
        AttributeBegin
        ActiveTransform EndTime Translate 3 0 0 ActiveTransform All Translate 0 0 5 Shape "sphere"
        AttributeEnd
    )");
    const std::string in_code_only = R"(
        WorldBegin
        LightSource "infinite" "rgb L" [.2 .9 .1]
        Translate 0 0 5 Material "diffuse" "rgb reflectance" [.9 .1 .1] Shape "sphere"
    )";
    // Files set a scene's space at their film; code sets it separately.
    folder.write("scene.pbrt", in_code_only);
    SceneDescription scene = scene_in_file(folder.path("scene.pbrt"));
    scene.color.scene_space = ColorSpace::rec2020;
    CHECK(again(scene, folder).color.scene_space == ColorSpace::rec2020);
}
