// Input that pbrt-v4 accepts with or without a warning and that occurs in public scenes: it must load here, too.
#include <catch2/catch.hpp>

#include <algorithm>

#include "tests/transport/import_support.h"

using namespace import_test;
using namespace raylex::transport;

namespace {

bool warns(const SceneDescription& scene, const std::string& part) {
    return std::any_of(scene.warnings.begin(), scene.warnings.end(),
                       [&](const raylex::Error& warning) { return contains(warning.message, part); });
}

}  // namespace

TEST_CASE("options without a type, in pbrt's notation", "[import]") {
    const SceneDescription scene = scene_of(R"(Option "disable-pixel-jitter" true
        Option "seed" 3
        Option "MSEReferenceImage" "image.exr"
        Option "disabletexturefiltering" true
        WorldBegin
        Texture "a" "spectrum" "constant")");
    CHECK(warns(scene, "option 'disablepixeljitter' has no effect here"));
    CHECK(warns(scene, "option 'msereferenceimage' has no effect here"));
    CHECK_FALSE(warns(scene, "disabletexturefiltering"));
}

TEST_CASE("the edges of displaced meshes are scaled by an option", "[import]") {
    const Folder folder;
    folder.write("m.ply",
                 "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
                 "z\nproperty float u\nproperty float v\nelement face 1\nproperty list uchar int "
                 "vertex_indices\nend_header\n0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n");
    const auto edge = [&](const std::string& option, const std::string& length) {
        const SceneDescription scene = scene_of(
            option +
                " WorldBegin Texture \"d\" \"float\" \"constant\" Shape \"plymesh\" \"string filename\" \"m.ply\" "
                "\"texture displacement\" \"d\" " +
                length,
            folder.path("s.pbrt"));
        REQUIRE(scene.shapes.size() == 1);
        return scene.shapes[0].edge_length;
    };
    CHECK(edge("", "") == 1);
    CHECK(edge("Option \"displacementedgescale\" 0.5", "\"float edgelength\" 3") == Real(1.5));
    CHECK(edge("", "\"float displacement.edgelength\" 3") == 3);
}

TEST_CASE("an included file may end within a directive's parameters", "[import]") {
    const Folder folder;
    folder.write("parts/medium.pbrt",
                 "MakeNamedMedium \"smoke\" \"string type\" \"uniformgrid\" \"float density\" [1]\n");
    folder.write("parts/outer.pbrt", "Include \"parts/medium.pbrt\"\n");
    const SceneDescription scene = scene_of(
        "WorldBegin\nInclude \"parts/outer.pbrt\"\n \"spectrum sigma_a\" [300 2 830 2] \"float g\" 0.5\nShape "
        "\"sphere\"",
        folder.path("s.pbrt"));
    REQUIRE(scene.media.size() == 1);
    CHECK(scene.media[0].parameters.find("density") != nullptr);
    CHECK(scene.media[0].parameters.find("sigma_a") != nullptr);
    CHECK(*scene.media[0].parameters.real_or("g", 0) == 0.5);
    CHECK(scene.shapes.size() == 1);
}

TEST_CASE("files of a directive at the end of an included file are searched beside that file", "[import]") {
    const Folder folder;
    folder.write("parts/m.ply",
                 "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
                 "float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 "
                 "0\n0 1 0\n3 0 1 2\n");
    folder.write("parts/mesh.pbrt", "Shape \"plymesh\" \"string filename\" \"m.ply\"");
    CHECK(scene_of("WorldBegin Include \"parts/mesh.pbrt\"\nShape \"sphere\"", folder.path("s.pbrt")).shapes.size() ==
          2);
}

TEST_CASE("names that no shape uses need not be defined, and media may be defined later", "[import]") {
    const SceneDescription scene = scene_of(R"(WorldBegin
        NamedMaterial "nobody" MediumInterface "nothing" ""
        Material "interface" MediumInterface "later" ""
        Shape "sphere"
        MakeNamedMedium "other" "string type" "homogeneous"
        MakeNamedMedium "later" "string type" "homogeneous")");
    REQUIRE(scene.shapes.size() == 1);
    CHECK(scene.shapes[0].inside_medium == 1);
    CHECK(scene.shapes[0].outside_medium == -1);
}

TEST_CASE("area lights emit nothing on shapes without a surface, as in pbrt", "[import]") {
    const SceneDescription scene = scene_of(R"(WorldBegin
        NamedMaterial "border" AreaLightSource "diffuse" "rgb L" [1 1 1]
        Shape "sphere"
        Material "" Shape "sphere"
        MakeNamedMaterial "border" "string type" "interface"
        MakeNamedMaterial "some" "string type" "mix" "string materials" ["border" "white"]
        MakeNamedMaterial "white" "string type" "diffuse"
        NamedMaterial "white" Shape "sphere"
        NamedMaterial "some" Shape "sphere")");
    REQUIRE(scene.shapes.size() == 4);
    for (std::size_t i : {0u, 1u}) CHECK(scene.shapes[i].area_light == -1);
    for (std::size_t i : {2u, 3u}) CHECK(scene.shapes[i].area_light == 0);
    REQUIRE(scene.warnings.size() == 2);
    CHECK(contains(scene.warnings[0].message, "area lights do not emit from shapes without a surface"));
    CHECK(scene.warnings[0].line == 3);
    CHECK(scene.warnings[1].line == 4);
}

TEST_CASE("lone ends of blocks and unknown coordinate systems are warnings", "[import]") {
    const SceneDescription scene = scene_of(R"(WorldBegin
        AttributeEnd CoordinateSystem "here" CoordSysTransform "there"
        Shape "sphere")");
    CHECK(scene.shapes.size() == 1);
    CHECK(warns(scene, "AttributeEnd without its AttributeBegin is ignored"));
    CHECK(warns(scene, "no coordinate system is called 'there'"));
}

TEST_CASE("values of a mesh are ignored if there are too many or too few", "[import]") {
    struct Case {
        std::string shape, values;
        const char* message;
        std::vector<std::uint32_t> indices;
    };
    const std::string triangle = R"(Shape "trianglemesh" "point3 P" [0 0 0  1 0 0  0 1 0])",
                      patch = R"(Shape "bilinearmesh" "point3 P" [0 0 0  1 0 0  0 1 0  1 1 0])";
    for (const Case& each :
         {Case{triangle, "\"point2 uv\" [0 0 1 1]", "'uv' has 2 points for 3 vertices; expected as many", {0, 1, 2}},
          Case{triangle, "\"normal N\" [0 0 1]", "'N' has 1 normals for 3 vertices; expected as many", {0, 1, 2}},
          Case{patch, "\"point2 uv\" [0 0 1 1 0 1]", "'uv' has 3 points for 4 vertices", {0, 1, 2, 3}},
          Case{patch, "\"normal N\" [0 0 1 0 0 1]", "'N' has 2 normals for 4 vertices", {0, 1, 2, 3}},
          Case{triangle,
               "\"integer indices\" [0 2 1 0]",
               "'indices' has 4 values; expected a multiple of 3, and the last 1 is ignored",
               {0, 2, 1}},
          Case{triangle, "\"integer indices\" [0 2 1 0 9]", "and the last 2 are ignored", {0, 2, 1}},
          Case{patch,
               "\"integer indices\" [0 1 2 3 0 1 2]",
               "'indices' has 7 values; expected a multiple of 4, and the last 3 are ignored",
               {0, 1, 2, 3}}}) {
        CAPTURE(each.shape, each.values);
        const SceneDescription scene = scene_of("WorldBegin " + each.shape + "\n" + each.values);
        REQUIRE(scene.shapes.size() == 1);
        CHECK(scene.shapes[0].indices == each.indices);
        CHECK(scene.shapes[0].uvs.empty());
        CHECK(scene.shapes[0].normals.empty());
        REQUIRE(scene.warnings.size() == 1);
        CHECK(contains(scene.warnings[0].message, each.message));
        CHECK(contains(scene.warnings[0].message, "ignored"));
        CHECK(scene.warnings[0].line == 2);
        CHECK(scene.warnings[0].column == 1);
    }
    CHECK(warns(scene_of(R"(WorldBegin Shape "loopsubdiv" "integer levels" 0 "point3 P" [0 0 0  1 0 0  0 1 0]
                            "integer indices" [0 1 2 1])"),
                "expected a multiple of 3, and the last 1 is ignored"));
}

TEST_CASE("quadrics of radius 0 have no area", "[import]") {
    const SceneDescription scene = scene_of(R"(WorldBegin
        Shape "sphere" "float radius" 0
        Shape "disk" "float radius" 0 "float innerradius" 0
        Shape "cylinder" "float radius" 0
        Shape "sphere" "float radius" 2)");
    REQUIRE(scene.shapes.size() == 1);
    CHECK(scene.shapes[0].radius == 2);
    REQUIRE(scene.warnings.size() == 3);
    for (int i = 0; i < 3; ++i) {
        const raylex::Error& warning = scene.warnings[static_cast<std::size_t>(i)];
        CHECK(contains(warning.message, "radius is 0; expected a length above 0"));
        CHECK(contains(warning.message, "is left out"));
        CHECK(warning.line == 2 + i);
    }
}

TEST_CASE("quadrics whose parameters leave no surface are omitted", "[import]") {
    const SceneDescription scene = scene_of(R"(WorldBegin
        Shape "disk" "float radius" 1 "float innerradius" 1
        Shape "disk" "float radius" 1 "float innerradius" 2
        Shape "sphere" "float phimax" 0
        Shape "sphere" "float radius" 2)");
    REQUIRE(scene.shapes.size() == 1);
    REQUIRE(scene.warnings.size() == 3);
    CHECK(contains(scene.warnings[0].message, "'innerradius' leaves no surface"));
    CHECK(contains(scene.warnings[1].message, "'innerradius' leaves no surface"));
    CHECK(contains(scene.warnings[2].message, "'phimax' leaves no surface"));
}

TEST_CASE("an unknown colour space keeps the previous one", "[import]") {
    const SceneDescription scene = scene_of("ColorSpace \"rec2020\"\nColorSpace \"rec2002\"\nFilm \"rgb\" WorldBegin");
    CHECK(scene.color.scene_space == ColorSpace::rec2020);
    REQUIRE(scene.warnings.size() == 1);
    CHECK(contains(scene.warnings[0].message, "unknown colour space 'rec2002'; expected srgb, dci-p3, rec2020 or"));
    CHECK(contains(scene.warnings[0].message, "The previous space stays in use"));
    CHECK(contains(scene.warnings[0].hint, "rec2020"));
    CHECK(scene.warnings[0].line == 2);
    CHECK(scene.warnings[0].column == 12);
}

TEST_CASE("lines of old Macintosh files", "[import]") {
    CHECK(scene_of("WorldBegin\r# a comment\rShape \"sphere\"\r").shapes.size() == 1);
}

TEST_CASE("text after type and name in a declaration is ignored", "[import]") {
    const SceneDescription scene = scene_of("WorldBegin Shape \"sphere\" \" float radius  (old)\" 2");
    CHECK(scene.shapes[0].radius == 2);
    CHECK(warns(scene, "the text after type and name"));
}

TEST_CASE("shapes under transformations without inverse: meshes are flat, other shapes have no area", "[import]") {
    const SceneDescription scene = scene_of(R"(WorldBegin
        Translate 1 2 3
        Scale 2 0 1
        Shape "sphere"
        Shape "trianglemesh" "point3 P" [0 5 0  1 6 0  0 7 1] "normal N" [0 0 1 0 0 1 0 0 1]
        Shape "trianglemesh" "point3 P" [0 0 0  1 0 0  0 1 0]
        ObjectBegin "a" ObjectEnd
        ObjectInstance "a")");
    REQUIRE(scene.shapes.size() == 1);
    CHECK(scene.shapes[0].object_to_world.is_identity());
    CHECK(scene.shapes[0].normals.empty());
    CHECK(scene.shapes[0].positions[1] == StoredVec3{3, 2, 3});
    CHECK(scene.shapes[0].positions[2] == StoredVec3{1, 2, 4});
    CHECK(scene.instances.empty());
    CHECK(warns(scene, "the shape has no area and is left out"));
    CHECK(warns(scene, "the shape is flat and uses face normals"));
    CHECK(warns(scene, "the instance has no extent and is left out"));
}

TEST_CASE("a shape that moves in an object also moves with every instance", "[import]") {
    const SceneDescription scene = scene_of(R"(WorldBegin
        ObjectBegin "a"
        Shape "disk"
        ActiveTransform EndTime Translate 1 0 0
        Shape "sphere"
        ObjectEnd
        Translate 0 0 5 ObjectInstance "a"
        ActiveTransform EndTime Translate 0 3 0
        ObjectInstance "a")");
    REQUIRE(scene.objects.size() == 2);
    REQUIRE(scene.instances.size() == 4);
    const auto place = [](const Transform& transform) {
        const auto& m = transform.matrix();
        return std::array<double, 3>{m[0][3], m[1][3], m[2][3]};
    };
    const SceneInstance &still = scene.instances[2], &moving = scene.instances[3];
    CHECK(still.object == 1);
    REQUIRE(still.motion >= 0);
    CHECK(place(still.to_world) == std::array<double, 3>{0, 0, 5});
    CHECK(place(scene.moved_to[static_cast<std::size_t>(still.motion)]) == std::array<double, 3>{1, 0, 5});
    REQUIRE(moving.motion >= 0);
    CHECK(place(scene.moved_to[static_cast<std::size_t>(moving.motion)]) == std::array<double, 3>{1, 3, 5});
}

TEST_CASE("meshes from files keep their order among shapes and warnings for any number of threads", "[import]") {
    const Folder folder;
    for (int i = 0; i < 9; ++i)
        folder.write("m" + std::to_string(i) + ".ply",
                     "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
                     "z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n" +
                         std::to_string(i) + " 0 0\n1 0 9\n0 1 0\n3 0 1 2\n3 0 0 1\n");
    std::string text =
        "WorldBegin ObjectBegin \"o\" Shape \"disk\" Shape \"plymesh\" \"string filename\" \"m0.ply\" ObjectEnd\n";
    for (int i = 1; i < 9; ++i)
        text += "Shape \"sphere\" \"float radius\" " + std::to_string(i) +
                " Shape \"plymesh\" \"string filename\" \"m" + std::to_string(i) + ".ply\"\n";
    for (const int threads : {1, 3}) {
        LoadingProgress progress;
        const auto scene = import_pbrt_text(text, folder.path("s.pbrt"), {.threads = threads, .progress = &progress});
        REQUIRE(scene.ok());
        REQUIRE(scene->shapes.size() == 16);
        REQUIRE(scene->objects[0].shapes.size() == 2);
        CHECK(scene->objects[0].shapes[1].source_file == "m0.ply");
        REQUIRE(scene->warnings.size() == 9);
        for (std::size_t i = 1; i < 9; ++i) {
            CHECK(scene->shapes[2 * i - 2].radius == static_cast<Real>(i));
            CHECK(scene->shapes[2 * i - 1].positions[0].x == static_cast<float>(i));
            CHECK(scene->warnings[i].line == static_cast<int>(i) + 1);
        }
        CHECK(progress.done() == 9);
        CHECK(progress.total() == 9);
    }
}

TEST_CASE("the first of several invalid meshes is the error for any number of threads", "[import][law7]") {
    const Folder folder;
    folder.write("a.ply", "no ply");
    folder.write("b.ply", "none either");
    const auto scene = import_pbrt_text(
        "WorldBegin\nShape \"plymesh\" \"string filename\" \"a.ply\"\n"
        "Shape \"plymesh\" \"string filename\" \"b.ply\"",
        folder.path("s.pbrt"));
    REQUIRE_FALSE(scene.ok());
    CHECK(scene.error().file == folder.path("a.ply"));
    CHECK(contains(scene.error().hint, "s.pbrt:2"));
}
