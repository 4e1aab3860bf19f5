// Curves as parts of scenes: made in code, written to files, refused, mirrored, rendered.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

#include "transport/import/builder/scene_builder.h"
#include "transport/import/pbrt/pbrt_writer.h"
#include "transport/render_support.h"
#include "transport/scene/scene_hash.h"

using namespace raylex;
using namespace raylex::transport;
using import_test::contains;
using import_test::scene_of;

TEST_CASE("curves made in code equal curves of a file", "[curves][scene-builder]") {
    CurveData data{CurveType::ribbon,
                   {{0, 0, 0}, {0, 1, 0}, {0, 2, 0}, {0, 3, 0}, {1, 0, 0}, {1, 1, 0}, {1, 2, 0}, {1, 3, 0}},
                   {0, 4},
                   {{0.5f, 0.25f}, {1, 1}},
                   {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {1, 0, 1}}};
    const auto built = [&data]() -> Result<SceneDescription> {
        SceneBuilder scene("code");
        if (Status s = scene.add_curves(data); !s) return s.error();
        return scene.finish();
    };
    const auto scene = built();
    REQUIRE(scene);
    const SceneDescription file = scene_of(
        "WorldBegin\nShape \"curve\" \"string type\" \"ribbon\" \"normal N\" [0 0 1 0 0 1] \"float width0\" 0.5 "
        "\"float width1\" 0.25 \"point3 P\" [0 0 0 0 1 0 0 2 0 0 3 0]\n"
        "Shape \"curve\" \"string type\" \"ribbon\" \"normal N\" [0 0 1 1 0 1] "
        "\"point3 P\" [1 0 0 1 1 0 1 2 0 1 3 0]\n");
    CHECK(scene_hash(*scene) == scene_hash(file));
    const auto refused = [&](const char* expected) {
        const auto found = built();
        REQUIRE_FALSE(found);
        INFO(found.error().to_string());
        CHECK(contains(found.error().message, expected));
        CHECK(contains(found.error().file, "curves_scene_test.cpp"));
    };
    const CurveData good = data;
    data.first_points = {0, 3};
    refused("curve 0 has a number of positions that is not 3 n + 1");
    data = good, data.widths[1].y = -1;
    refused("a width of curve 1 is negative");
    data = good, data.normals.pop_back();
    refused("3 normals of curves; expected 4");
    data = good, data.normals[2] = {};
    refused("normal 2 of the ribbons is zero");
    data = good, data.points[5].x = HUGE_VALF;
    refused("control point 5 of the curves is not finite");
    data = good, data.widths.clear();
    refused("0 pairs of widths for 2 curves");
}

TEST_CASE("curves written to a pbrt file are read as the same curves", "[curves][pbrt-writer]") {
    const import_test::Folder folder;
    const SceneDescription scene = scene_of(R"(
        Camera "perspective"
        WorldBegin
        Texture "holes" "float" "checkerboard" "float tex1" 1 "float tex2" 0.5
        Rotate 20 1 0 1
        ReverseOrientation
        Shape "curve" "string type" "ribbon" "normal N" [0 0 1 0 0.1 1 1 0 0.1] "float width0" 0.1 "float width1" 0.3
            "string basis" "bspline" "point3 P" [0 0 0 0.1 1 0 0.2 2 0.1 0.3 3 0.7 0.2 4 1]
        Shape "curve" "string type" "ribbon" "normal N" [0 0 1 0 0.1 1] "float width" 0.3
            "point3 P" [0 0 0 0.1 1 0 0.2 2 0.1 0.3 3 0.7]
        MakeNamedMaterial "hair" "string type" "diffuse"
        NamedMaterial "hair"
        Shape "curve" "string type" "cylinder" "integer degree" 2 "point3 P" [0 0 0.1 1 2 3 0 2 0] "texture alpha" "holes"
        ObjectBegin "lock"
        Shape "curve" "point3 P" [0 0 0 0 1 0 0 2 0 0 3 0] "float alpha" 0.5
        Shape "curve" "point3 P" [0 0 0 0 1 0 0 2 0 0 3 0.5] "float alpha" 0.5
        ObjectEnd
        ObjectInstance "lock"
    )");
    REQUIRE(scene.shapes.size() == 2);
    const auto written = write_pbrt(scene, folder.path("again.pbrt"));
    REQUIRE(written);
    CHECK(written->empty());
    const auto again = import_pbrt(folder.path("again.pbrt"));
    if (!again) FAIL(again.error().to_string());
    CHECK(scene_hash(*again) == scene_hash(scene));
}

TEST_CASE("a cylinder made of curves renders like a cylinder", "[curves][render]") {
    const std::string scene = R"(
Film "rgb" "integer xresolution" 32 "integer yresolution" 32
PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
Sampler "zsobol" "integer pixelsamples" 64
Integrator "path" "integer maxdepth" 2
LookAt 0 0 8  0 0 0  0 1 0
Camera "perspective" "float fov" 14
WorldBegin
LightSource "distant" "point3 from" [3 1 4] "point3 to" [0 0 0]
Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
Rotate 90 1 0 0
)";
    const auto curve =
        render_test::render_of(scene_of(scene + "Shape \"curve\" \"string type\" \"cylinder\" \"float width\" 1 "
                                                "\"point3 P\" [0 0 -3 0 0 -1 0 0 1 0 0 3]"));
    const auto shape = render_test::render_of(
        scene_of(scene + "Shape \"cylinder\" \"float radius\" 0.5 \"float zmin\" -3 \"float zmax\" 3"));
    const std::vector<double> a = curve.frame_buffer.resolve(curve.beauty),
                              b = shape.frame_buffer.resolve(shape.beauty);
    double worst = 0, brightest = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        worst = std::max(worst, std::abs(a[i] - b[i])), brightest = std::max(brightest, b[i]);
    CHECK(brightest > 0.1);
    // The rays are equal: a sample or two of 64 hit a silhouette or a terminator within rounding.
    CHECK(worst < 2.0 / 64 * brightest);
}

TEST_CASE("ribbons too wide for Embree are refused, others are not", "[curves][law7]") {
    const auto built = [](const std::string& curve) {
        return BuiltScene::build(scene_of("WorldBegin\nTranslate 0 0 5\nShape \"curve\" " + curve));
    };
    const std::string points = " \"point3 P\" [-1 0 0 0 1 0 .5 0 0 1 1 0]", ribbon = "\"string type\" \"ribbon\" ",
                      normals = " \"normal N\" [0 0 1 0 0 1]";
    const auto refused = built(ribbon + normals + points + " \"float width\" 1e6");
    REQUIRE_FALSE(refused.ok());
    CHECK(refused.error().line == 3);
    CHECK(contains(refused.error().message,
                   "segment 0 of ribbon 0 is more than 10^5 times as wide (1e+06) as it is long (2)"));
    CHECK(built(ribbon + normals + points + " \"float width\" 1e5").ok());
    CHECK(built(points + " \"float width\" 1e6").ok());  // flat, which Embree handles
    const auto dot = built(ribbon + normals + " \"point3 P\" [1 1 0 1 1 0 1 1 0 1 1 0]");
    REQUIRE(dot.ok());
    CHECK(contains((*dot)->warnings.front().message, "have no length"));
}

TEST_CASE("hair under a mirroring transform equals hair with mirrored points, for shapes and instances",
          "[curves][hair][render]") {
    // A strand lit and seen from the side, across which R, TT and TRT differ; it is as wide as the image.
    const std::string view =
        "Film \"rgb\" \"integer xresolution\" 16 \"integer yresolution\" 4\n"
        "Sampler \"independent\" \"integer pixelsamples\" 16\nIntegrator \"path\" \"integer maxdepth\" 1\n"
        "LookAt 0 0 -6  0 0 0  0 1 0\nCamera \"perspective\" \"float fov\" 6\nWorldBegin\n"
        "LightSource \"distant\" \"point3 from\" [-3 1 -2] \"point3 to\" [0 0 0]\n";
    const auto strand = [](const char* points) {
        return "Material \"hair\" \"rgb sigma_a\" [.3 .5 .8] \"float beta_n\" 0.2\nShape \"curve\" \"float width\" 2 "
               "\"string type\" \"flat\" \"point3 P\" [" +
               std::string(points) + "]\n";
    };
    const std::string own = strand("0 -9 0 .2 -3 0 .2 3 0 0 9 0"), turned = strand("0 -9 0 -.2 -3 0 -.2 3 0 0 9 0");
    const auto image = [&](const std::string& world) {
        auto output = render(scene_of(view + world), {});
        REQUIRE(output.ok());
        return output->frame_buffer.resolve(0);
    };
    const auto by_hand = image(turned), direct = image("Scale -1 1 1\n" + own),
               instanced = image("ObjectBegin \"s\"\n" + own + "ObjectEnd\nScale -1 1 1\nObjectInstance \"s\"\n"),
               unturned = image(own);
    double brightest = 0, off_direct = 0, off_instanced = 0, off_unturned = 0;
    for (std::size_t i = 0; i < by_hand.size(); ++i) {
        brightest = std::max(brightest, by_hand[i]);
        off_direct = std::max(off_direct, std::abs(by_hand[i] - direct[i]));
        off_instanced = std::max(off_instanced, std::abs(by_hand[i] - instanced[i]));
        off_unturned = std::max(off_unturned, std::abs(by_hand[i] - unturned[i]));
    }
    CHECK(off_unturned > 0.05 * brightest);  // otherwise the test would detect nothing
    // The points have the same numbers; with an instance, rays are rounded to float elsewhere: 1e-5 of an h.
    CHECK(off_direct <= 1e-6 * brightest);
    CHECK(off_instanced <= 1e-3 * brightest);
}
