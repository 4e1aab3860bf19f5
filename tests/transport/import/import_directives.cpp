// Every directive of pbrt-v4, tested by its effect on the scene.
#include <catch2/catch.hpp>

#include <zlib.h>

#include "tests/support/paths.h"
#include "tests/transport/import_support.h"
#include "transport/media/medium.h"

using namespace import_test;
using namespace raylex::transport;

namespace {

const std::string triangle_line = "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0]\n";

std::string gzip(const std::string& text) {
    std::string result(text.size() + 64, '\0');
    z_stream stream{};
    REQUIRE(deflateInit2(&stream, 6, Z_DEFLATED, 16 + MAX_WBITS, 8, Z_DEFAULT_STRATEGY) == Z_OK);
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
    stream.avail_in = static_cast<uInt>(text.size());
    stream.next_out = reinterpret_cast<Bytef*>(result.data());
    stream.avail_out = static_cast<uInt>(result.size());
    REQUIRE(deflate(&stream, Z_FINISH) == Z_STREAM_END);
    result.resize(stream.total_out);
    deflateEnd(&stream);
    return result;
}

}  // namespace

TEST_CASE("settings before WorldBegin are kept as written", "[import]") {
    const SceneDescription scene = scene_of(R"(# settings
        Option "bool disablepixeljitter" true
        ColorSpace "rec2020"
        Film "rgb" "integer xresolution" [ 320 ] "string filename" "a\"b\\c.exr" "bool savefp16" false
        Sampler "zsobol" "integer pixelsamples" 16
        PixelFilter "gaussian" "float xradius" 1.5
        Integrator "volpath" "integer maxdepth" [ 7 ]
        Accelerator "bvh" "string splitmethod" "sah"
        TransformTimes 0 1
        MediumInterface "" ""
        MediumInterface ""
        MakeNamedMedium "unused" "string type" "homogeneous"
        Camera "perspective" "float fov" +39 "float screenwindow" [ -1 1 -1 1 ]
        WorldBegin)");
    CHECK(scene.color.scene_space == ColorSpace::rec2020);
    CHECK(scene.film.type == "rgb");
    CHECK(*scene.film.parameters.integer_or("xresolution", 0) == 320);
    CHECK(*scene.film.parameters.string_or("filename", "") == "a\"b\\c.exr");
    CHECK_FALSE(*scene.film.parameters.boolean_or("savefp16", true));
    CHECK(scene.sampler.type == "zsobol");
    CHECK(scene.filter.type == "gaussian");
    CHECK(*scene.filter.parameters.real_or("xradius", 0) == 1.5);
    CHECK(scene.integrator.type == "volpath");
    CHECK(*scene.integrator.parameters.integer_or("maxdepth", 0) == 7);
    CHECK(scene.camera.type == "perspective");
    CHECK(*scene.camera.parameters.real_or("fov", 0) == 39);
    CHECK(scene.camera.location.line == 13);
    REQUIRE(scene.warnings.size() == 1);  // the option
    CHECK(scene.warnings[0].line == 2);
}

TEST_CASE("materials, textures, lights and shapes are kept with their graphics state", "[import]") {
    const SceneDescription scene = scene_of(R"(WorldBegin
        Texture "grain" "float" "constant" "float value" 0.5
        Translate 1 2 3
        Texture "grain" "spectrum" "constant" "rgb value" [0.1 0.2 0.3]
        Identity
        LightSource "point" "rgb I" [1 2 3] "point3 from" [0 2 0]
        NamedMaterial "late"
        Shape "sphere" "float radius" 2 "float alpha" 0.25
        MakeNamedMaterial "late" "string type" "conductor" "texture roughness" "grain"
        AttributeBegin
          AreaLightSource "diffuse" "rgb L" [4 4 4]
          Material "diffuse" "texture reflectance" "grain"
          ReverseOrientation
          Shape "disk" "texture alpha" "grain" "float height" 1
        AttributeEnd
        Shape "cylinder"
        Material "" Shape "bilinearmesh" "point3 P" [0 0 0 1 0 0 0 1 0 1 1 0])");
    REQUIRE(scene.textures.size() == 2);
    CHECK_FALSE(scene.textures[0].spectrum);
    CHECK(scene.textures[1].spectrum);
    CHECK(scene.textures[1].to_world.matrix()[2][3] == 3);
    REQUIRE(scene.lights.size() == 1);
    CHECK(scene.lights[0].type == "point");
    CHECK(scene.lights[0].to_world.is_identity());
    REQUIRE(scene.materials.size() == 4);
    CHECK(scene.materials[0].type == "diffuse");
    CHECK(scene.materials[1].name == "late");
    CHECK(scene.materials[1].parameters.find("type") == nullptr);
    CHECK(scene.materials[3].type == "interface");
    REQUIRE(scene.shapes.size() == 4);
    CHECK(scene.shapes[0].kind == ShapeKind::sphere);
    CHECK(scene.shapes[0].radius == 2);
    CHECK(scene.shapes[0].z_min == -2);
    CHECK(scene.shapes[0].alpha == 0.25f);
    CHECK(scene.shapes[0].material == 1);
    CHECK(scene.shapes[0].label == "late");
    CHECK(scene.shapes[0].area_light == -1);
    CHECK(scene.shapes[1].alpha_texture == "grain");
    CHECK(scene.shapes[1].height == 1);
    CHECK(scene.shapes[1].area_light == 0);
    CHECK(scene.shapes[1].flip_normal);
    CHECK(scene.shapes[1].label.empty());
    CHECK(scene.shapes[2].material == 1);
    CHECK_FALSE(scene.shapes[2].flip_normal);
    CHECK(scene.shapes[2].area_light == -1);
    CHECK(scene.shapes[3].kind == ShapeKind::bilinear_mesh);
    CHECK(scene.shapes[3].indices == std::vector<std::uint32_t>{0, 1, 2, 3});
}

TEST_CASE("Attribute sets parameters that a directive does not give, until its block ends", "[import]") {
    const SceneDescription scene = scene_of(R"(WorldBegin
        AttributeBegin
          Attribute "shape" "float radius" 3
          Attribute "light" "float scale" 5
          Attribute "material" "float roughness" 0.25
          Attribute "texture" "float value" 0.75
          Shape "sphere"  Shape "sphere" "float radius" 7
          LightSource "infinite"
          Material "conductor"  MakeNamedMaterial "m" "string type" "conductor" "float roughness" 0.5
          Texture "t" "float" "constant"
        AttributeEnd
        Shape "sphere")");
    CHECK(scene.shapes[0].radius == 3);
    CHECK(scene.shapes[1].radius == 7);
    CHECK(scene.shapes[2].radius == 1);
    CHECK(*scene.lights[0].parameters.real_or("scale", 0) == 5);
    CHECK(*scene.materials[1].parameters.real_or("roughness", 0) == 0.25);
    CHECK(*scene.materials[2].parameters.real_or("roughness", 0) == 0.5);
    CHECK(*scene.textures[0].parameters.real_or("value", 0) == 0.75);
    CHECK(scene.warnings.empty());
}

TEST_CASE("objects contain shapes in their own space and instances contain the transform", "[import]") {
    const SceneDescription scene = scene_of(
        "WorldBegin ObjectInstance \"tree\"\n"
        "AttributeBegin Translate 5 0 0 ObjectBegin \"tree\" Scale 2 2 2\n" +
        triangle_line + "ObjectEnd Translate 0 1 0 ObjectInstance \"tree\" AttributeEnd\n" + triangle_line);
    REQUIRE(scene.objects.size() == 1);
    REQUIRE(scene.objects[0].shapes.size() == 1);
    CHECK(placed(scene.objects[0].shapes[0]).positions[1] ==
          Vec3{7, 0, 0});  // the transform at the definition is part of the object
    REQUIRE(scene.instances.size() == 2);
    CHECK(scene.instances[0].object == 0);
    CHECK(scene.instances[0].to_world.is_identity());
    CHECK(scene.instances[1].to_world.point({0, 0, 0}) == Vec3{5, 1, 0});  // ObjectEnd restored the scale
    REQUIRE(scene.shapes.size() == 1);
    CHECK(placed(scene.shapes[0]).positions[1] == Vec3{1, 0, 0});
}

TEST_CASE("an area light inside an object emits nothing, as in pbrt, with a warning", "[import]") {
    const SceneDescription scene =
        scene_of("WorldBegin ObjectBegin \"o\"\nAreaLightSource \"diffuse\"\n" + triangle_line + "ObjectEnd");
    CHECK(scene.objects[0].shapes[0].area_light == -1);
    REQUIRE(scene.warnings.size() == 1);
    CHECK(contains(scene.warnings[0].message, "do not emit"));
}

TEST_CASE("Include shares the graphics state, Import has its own, and both read gzip files", "[import]") {
    const Folder folder;
    folder.write("parts/inner.pbrt", triangle_line);
    folder.write("parts/included.pbrt.gz", gzip("Translate 1 0 0 Include \"parts/inner.pbrt\"\n"));
    folder.write("parts/beside.pbrt", "Include \"inner.pbrt\"\n");  // found beside the file that names it
    folder.write("imported.pbrt",
                 "Translate 0 0 9 CoordinateSystem \"there\" MakeNamedMaterial \"m\" \"string type\" \"diffuse\" "
                 "NamedMaterial \"m\" " +
                     triangle_line);
    const auto scene = import_pbrt(folder.write(
        "scene.pbrt", "WorldBegin Include \"parts/included.pbrt.gz\" Import \"imported.pbrt\"\n" + triangle_line +
                          "Include \"parts/beside.pbrt\" NamedMaterial \"m\" " + triangle_line));
    if (!scene) FAIL(scene.error().to_string());
    REQUIRE(scene->shapes.size() == 5);
    CHECK(placed(scene->shapes[0]).positions[0] == Vec3{1, 0, 0});
    CHECK(placed(scene->shapes[1]).positions[0] == Vec3{1, 0, 9});
    CHECK(scene->shapes[1].label == "m");
    CHECK(placed(scene->shapes[2]).positions[0] == Vec3{1, 0, 0});  // the import's translation ended with it
    CHECK(scene->shapes[2].label.empty());
    CHECK(scene->shapes[4].label == "m");  // the import's named material remains
}

TEST_CASE("file names become absolute, the scene's folder before the including file's", "[import]") {
    const Folder folder;
    folder.write("a.png", "");
    folder.write("parts/a.png", "");
    folder.write("parts/b.spd", "400 1 700 1");
    folder.write("parts/textures.pbrt",
                 "Texture \"a\" \"float\" \"imagemap\" \"string filename\" \"a.png\"\n"
                 "Material \"conductor\" \"spectrum eta\" \"b.spd\" \"spectrum k\" \"metal-Cu-k\"");
    const auto scene = import_pbrt(folder.write("scene.pbrt", "WorldBegin Include \"parts/textures.pbrt\"\n"));
    if (!scene) FAIL(scene.error().to_string());
    CHECK(*scene->textures[0].parameters.string_or("filename", "") == folder.path("a.png"));
    CHECK(scene->materials[1].parameters.find("eta")->strings[0] == folder.path("parts/b.spd"));
    CHECK(scene->materials[1].parameters.find("k")->strings[0] == "metal-Cu-k");
}

TEST_CASE("a degenerate triangle_line is dropped with one warning, a thin one stays", "[import]") {
    const SceneDescription scene = scene_of(
        "WorldBegin Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 2 0 0 1 1e-30 0]\n"
        "\"integer indices\" [0 0 1  0 1 2  0 1 3  0 1 4]");
    REQUIRE(scene.shapes.size() == 1);
    CHECK(scene.shapes[0].indices == std::vector<std::uint32_t>{0, 1, 2, 0, 1, 4});
    REQUIRE(scene.warnings.size() == 1);
    CHECK(contains(scene.warnings[0].message, "2 of the faces"));
    CHECK(scene_of("WorldBegin Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 2 0 0]").shapes.empty());
}

TEST_CASE("a parameter given twice keeps the last value", "[import]") {
    const SceneDescription scene = scene_of("WorldBegin Shape \"sphere\" \"float radius\" 1 \"float radius\" 2");
    CHECK(scene.shapes[0].radius == 2);
    REQUIRE(scene.warnings.size() == 1);
    CHECK(contains(scene.warnings[0].message, "given twice"));
}

TEST_CASE("rgb values in another colour space are converted to the film's", "[import]") {
    const SceneDescription scene = scene_of(R"(Film "rgb"
        WorldBegin ColorSpace "rec2020"
        Material "diffuse" "rgb reflectance" [1 1 1]
        Material "diffuse" "rgb reflectance" [0.5 0.2 0.1]
        Material "conductor" "rgb eta" [0.2 0.9 1.1]
        LightSource "infinite" "rgb L" [2 2 2])");
    const auto numbers = [](const SceneEntity& entity, const char* name) {
        return entity.parameters.find(name)->numbers;
    };
    // Both spaces share D65; 1e-9 covers the rounding of two matrix products.
    for (const double c : numbers(scene.materials[1], "reflectance")) CHECK(c == Approx(1).margin(1e-9));
    for (const double c : numbers(scene.lights[0], "L")) CHECK(c == Approx(2).margin(1e-9));
    // BT.2087: linear Rec. 2020 to Rec. 709; 2e-3 covers its rounded white point.
    const auto rgb = numbers(scene.materials[2], "reflectance");
    CHECK(rgb[0] == Approx(1.6605 * 0.5 - 0.5876 * 0.2 - 0.0728 * 0.1).margin(2e-3));
    CHECK(rgb[1] == Approx(-0.1246 * 0.5 + 1.1329 * 0.2 - 0.0083 * 0.1).margin(2e-3));
    CHECK(rgb[2] == Approx(-0.0182 * 0.5 - 0.1006 * 0.2 + 1.1187 * 0.1).margin(2e-3));
    CHECK(numbers(scene.materials[3], "eta") == std::vector<double>{0.2, 0.9, 1.1});  // not a colour: unchanged
}

TEST_CASE("a million numbers in one list parse in linear time", "[import]") {
    std::string text = "WorldBegin Shape \"trianglemesh\" \"point3 P\" [";
    for (int i = 0; i < 100000; ++i) text += "0 0 0 1 0.25 0 0 -1.5e-1 2 ";
    text += "] \"integer indices\" [";
    for (int i = 0; i < 300000; i += 3)
        text += std::to_string(i) + " " + std::to_string(i + 1) + " " + std::to_string(i + 2) + " ";
    const SceneDescription scene = scene_of(text + "]");
    CHECK(scene.shapes[0].indices.size() == 300000);
    CHECK(placed(scene.shapes[0]).positions[299999] == Vec3{0, -0.15f, 2});
}

TEST_CASE("the scenes that ship with the project are read without a warning", "[import]") {
    for (const char* name : {"cornell-color", "cornell-grey", "furnace-box", "furnace-sphere", "mis-plates",
                             "point-plane", "sky-image", "still-life"}) {
        INFO(name);
        const auto scene = import_pbrt(raylex::test::source_dir() + "/experiments/scenes/" + name + "/scene.pbrt");
        if (!scene) FAIL(scene.error().to_string());
        CHECK(scene->warnings.empty());
        CHECK_FALSE(scene->shapes.empty());
        CHECK(scene->lights.size() + scene->area_lights.size() > 0);
    }
}

TEST_CASE("media are on the sides that MediumInterface names, and around the camera", "[import]") {
    const SceneDescription scene = scene_of(R"(
        MakeNamedMedium "a" "string type" "homogeneous" "rgb sigma_s" [2 3 4]
        MakeNamedMedium "b" "string type" "homogeneous" "string preset" "Skin1"
        MediumInterface "a" "b"
        Camera "perspective"
        WorldBegin
        Shape "sphere"
        AttributeBegin
          MediumInterface "" "a"
          Shape "sphere"
        AttributeEnd
        MediumInterface "b"
        ObjectBegin "o"
          Shape "sphere"
        ObjectEnd)");
    CHECK(scene.media.size() == 2);
    CHECK(scene.media[1].name == "b");
    CHECK(scene.media[1].type == "homogeneous");
    CHECK(scene.media[1].parameters.find("type") == nullptr);
    CHECK(scene.camera_medium == 1);
    REQUIRE(scene.shapes.size() == 2);
    CHECK(scene.shapes[0].inside_medium == 0);
    CHECK(scene.shapes[0].outside_medium == 1);
    CHECK(scene.shapes[1].inside_medium == -1);
    CHECK(scene.shapes[1].outside_medium == 0);
    CHECK(scene.objects[0].shapes[0].inside_medium == 1);
    CHECK(scene.objects[0].shapes[0].outside_medium == 1);

    std::vector<raylex::Error> warnings;
    auto media = MediumTable::build(scene, warnings);
    REQUIRE(media.ok());
    CHECK(warnings.empty());
    CHECK(media->any());
    CHECK((*media)[0].sigma_s == raylex::Rgb(2, 3, 4));
    CHECK((*media)[0].sigma_a == raylex::Rgb(1));
    CHECK((*media)[1].sigma_s == raylex::Rgb(0.74f, 0.88f, 1.01f));
    CHECK((*media)[1].sigma_a == raylex::Rgb(0.032f, 0.17f, 0.48f));
}

TEST_CASE("invalid media are errors at their position", "[import][law7]") {
    struct Slip {
        const char *text, *message, *hint;
    };
    const Slip slips[] = {
        {"\"string type\" \"openvdb\"", "unknown medium 'openvdb'; expected one of: homogeneous", ""},
        {"\"string type\" \"homogenous\"", "unknown medium 'homogenous'", "'homogeneous'"},
        {"\"string type\" \"homogeneous\" \"rgb sigma_s\" [1 -1 1]", "sigma_s", ""},
        {"\"string type\" \"homogeneous\" \"float scale\" -1", "expected 0 or more", ""},
    };
    for (const Slip& slip : slips) {
        CAPTURE(slip.text);
        const std::string make = std::string("MakeNamedMedium \"fog\" ") + slip.text + "\n";
        std::vector<raylex::Error> warnings;
        const SceneDescription used =
            scene_of(make + "MediumInterface \"fog\" \"\"\nCamera \"perspective\"\nWorldBegin\nShape \"sphere\"");
        auto media = MediumTable::build(used, warnings);
        REQUIRE_FALSE(media.ok());
        CHECK(contains(media.error().message, slip.message));
        CHECK(contains(media.error().hint, slip.hint));
        CHECK(media.error().file == "test.pbrt");
        CHECK(media.error().line == 1);
        const SceneDescription unused = scene_of(make + "Camera \"perspective\"\nWorldBegin\nShape \"sphere\"");
        CHECK(MediumTable::build(unused, warnings).ok());
    }
    std::vector<raylex::Error> warnings;
    const SceneDescription odd = scene_of(
        "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" \"string preset\" \"Skin1\"\n"
        "\"rgb sigma_a\" [1 1 1] MediumInterface \"fog\"\nCamera \"perspective\"\nWorldBegin\nShape \"sphere\"");
    REQUIRE(MediumTable::build(odd, warnings).ok());
    REQUIRE(warnings.size() == 1);
    CHECK(contains(warnings[0].message, "'sigma_a' has no effect on medium 'fog'"));
}

TEST_CASE("a medium with an unknown preset uses its coefficients, and the asymmetry is clamped, as in pbrt",
          "[import]") {
    const SceneDescription scene = scene_of(
        "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\"\n\"string preset\" \"Skin\"\n\"float g\" -1\n"
        "\"rgb sigma_s\" [2 3 4] MediumInterface \"fog\"\nCamera \"perspective\"\nWorldBegin\nShape \"sphere\"");
    std::vector<raylex::Error> warnings;
    auto media = MediumTable::build(scene, warnings);
    REQUIRE(media.ok());
    CHECK((*media)[0].sigma_s == raylex::Rgb(2, 3, 4));
    CHECK((*media)[0].sigma_a == raylex::Rgb(1));
    CHECK((*media)[0].g == Real(-0.99));
    REQUIRE(warnings.size() == 2);
    CHECK(contains(warnings[0].message, "there is no measured medium 'Skin'; expected one of: Apple"));
    CHECK(contains(warnings[0].message, "'sigma_a' and 'sigma_s' are used instead"));
    CHECK(contains(warnings[0].hint, "'Skin1'"));
    CHECK(warnings[0].line == 2);
    CHECK(contains(warnings[1].message, "'g' is -1; expected an asymmetry above -1 and below 1"));
    CHECK(contains(warnings[1].message, "-0.99"));
    CHECK(warnings[1].line == 3);
}
