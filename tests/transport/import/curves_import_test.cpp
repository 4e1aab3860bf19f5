// Curves in scene files: their shapes, errors and warnings.
#include <catch2/catch.hpp>

#include "transport/embree/embree_scene.h"
#include "transport/render_support.h"

using namespace raylex;
using namespace raylex::transport;
using import_test::contains;
using import_test::error_of;
using import_test::scene_of;

namespace {

EmbreeScene embree_of(const SceneDescription& scene) {
    TextureTable textures;
    auto built = EmbreeScene::build(scene, textures, {});
    if (!built) FAIL(built.error().to_string());
    return *std::move(built);
}

}  // namespace

TEST_CASE("curves that differ only in their points are one shape", "[curves][import]") {
    const std::string curve = "Shape \"curve\" \"point3 P\" [0 0 0 0 1 0 0 2 0 0 3 0]\n";
    const SceneDescription scene = scene_of(
        "WorldBegin\nMakeNamedMaterial \"hair\" \"string type\" \"diffuse\"\n"
        "NamedMaterial \"hair\"\n" +
        curve + curve + "AttributeBegin\nNamedMaterial \"hair\"\n" + curve + "AttributeEnd\n" + curve +
        "Material \"diffuse\"\n" + curve + "Translate 1 0 0\n" + curve + "ReverseOrientation\n" + curve);
    REQUIRE(scene.shapes.size() == 4);
    CHECK(scene.shapes[0].indices == std::vector<std::uint32_t>{0, 4, 8, 12});
    CHECK(scene.shapes[0].curve_widths.size() == 4);
    CHECK(scene.shapes[0].label == "hair");
    const EmbreeScene built = embree_of(scene);
    CHECK(built.shapes()[0].primitive_count == 4);
    CHECK(built.shapes()[3].curves.reversed);
}

TEST_CASE("B-splines and quadratic curves become equivalent Bezier segments", "[curves][import]") {
    const auto points = [](const std::string& text) {
        return scene_of("WorldBegin\nShape \"curve\" " + text).shapes.at(0).positions;
    };
    // A uniform quadratic B-spline joins at the middles of its control polygon.
    const auto quadratic =
        points("\"string basis\" \"bspline\" \"integer degree\" 2 \"point3 P\" [0 0 0 2 0 0 2 2 0 0 2 0]");
    REQUIRE(quadratic.size() == 7);
    CHECK(quadratic[0] == StoredVec3{1, 0, 0});
    CHECK(quadratic[3] == StoredVec3{2, 1, 0});
    CHECK(quadratic[6] == StoredVec3{1, 2, 0});
    CHECK(quadratic[1] == to_float(BasicVec3<double>{5.0 / 3, 0, 0}));
    // A cubic one passes (P0 + 4 P1 + P2) / 6, with tangents along P2 - P0.
    const auto cubic = points("\"string basis\" \"bspline\" \"point3 P\" [0 0 0 6 0 0 6 6 0 0 6 0 0 0 0]");
    REQUIRE(cubic.size() == 7);
    CHECK(cubic[0] == StoredVec3{5, 1, 0});
    CHECK(cubic[1] == StoredVec3{6, 2, 0});
    CHECK(cubic[3] == StoredVec3{5, 5, 0});
    CHECK(cubic[6] == StoredVec3{1, 5, 0});
}

TEST_CASE("invalid curves are errors at their line", "[curves][import][law7]") {
    const auto error = [](const std::string& text) { return error_of("WorldBegin\nShape \"curve\" " + text); };
    const std::string four = "\"point3 P\" [0 0 0 0 1 0 0 2 0 0 3 0] ";
    struct Case {
        std::string text;
        const char* expected;
    };
    for (const Case& each :
         {Case{"", "curve has 0 control points"}, Case{"\"point3 P\" [0 0 0 1 1 1 2 2 2]", "expected 4 + 3 n"},
          Case{"\"point3 P\" [0 0 0 1 1 1] \"string basis\" \"bspline\" \"integer degree\" 2", "expected 3 or more"},
          Case{four + "\"string basis\" \"nurbs\"", "expected bezier or bspline"},
          Case{four + "\"integer degree\" 4", "expected 2 or 3"}, Case{four + "\"float width\" -1", "at least 0"},
          Case{four + "\"float width1\" 1e39", "beyond the range of float"},
          Case{four + "\"string type\" \"ribbon\"", "has 0 normals; expected one at each end"},
          Case{four + "\"string type\" \"ribbon\" \"normal N\" [0 0 0 0 0 1]", "normal 0 of a ribbon is zero"},
          Case{four + "\"float P\" 3", "P"}, Case{four + "\"float radius\" 3", "no parameter 'radius'"},
          Case{"\"point3 P\" [0 0 0 0 1 0 0 2 0 0 1e39 0]", "beyond the range of float"}}) {
        INFO(each.text);
        const Error found = error(each.text);
        CHECK(found.line == 2);
        INFO(found.to_string());
        CHECK(contains(found.message, each.expected));
    }
    auto lit = render(
        scene_of("Camera \"perspective\"\nWorldBegin\nAreaLightSource \"diffuse\"\nShape \"curve\" " + four), {});
    REQUIRE_FALSE(lit);
    CHECK(lit.error().line == 4);
    CHECK(contains(lit.error().message, "curves with an area light are not supported"));
}

TEST_CASE("a curve of an unknown type is a cylinder, as in pbrt", "[curves][import]") {
    const SceneDescription scene =
        scene_of("WorldBegin\nShape \"curve\" \"point3 P\" [0 0 0 0 1 0 0 2 0 0 3 0]\n\"string type\" \"round\"");
    REQUIRE(scene.shapes.size() == 1);
    CHECK(scene.shapes[0].curve_type == CurveType::cylinder);
    REQUIRE(scene.warnings.size() == 1);
    CHECK(contains(scene.warnings[0].message,
                   "'type' of a curve is 'round'; expected flat, cylinder or ribbon. It is read as cylinder"));
    CHECK(scene.warnings[0].line == 3);
}

TEST_CASE("omitted parts and unused parameters of curves give one warning each", "[curves][import]") {
    const std::string four = "Shape \"curve\" \"integer splitdepth\" 2 \"point3 P\" [0 0 0 0 1 0 0 2 0 0 3 0]\n";
    const SceneDescription scene = scene_of("WorldBegin\n" + four + four +
                                            "Shape \"curve\" \"point3 P\" [1 1 1 1 1 1 1 1 1 1 1 1]\n"
                                            "Scale 1 2 1\n" +
                                            four);
    REQUIRE(scene.warnings.size() == 1);
    CHECK(contains(scene.warnings[0].message, "parameter 'splitdepth' of shape 'curve' is ignored"));
    const EmbreeScene built = embree_of(scene);
    REQUIRE(built.warnings().size() == 2);
    CHECK(contains(built.warnings()[0].message, "1 segments of curves have no length"));
    CHECK(contains(built.warnings()[1].message, "does not keep circles"));
}
