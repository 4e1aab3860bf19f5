// A scene near the origin and far away, by transforms in the file: light transport computes near the scene.
#include "transport/geometry/render_space.h"
#include "tests/transport/render_support.h"

using namespace render_test;
using transport::DVec3;
using transport::RenderSpace;
using transport::Transform;

namespace {

std::string coordinates(double x, double y, double z) {
    char text[96];
    std::snprintf(text, sizeof text, "%.17g %.17g %.17g ", x, y, z);
    return text;
}

void replace(std::string& text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    REQUIRE(at != std::string::npos);
    text.replace(at, from.size(), to);
}

/// Every kind of shape, light, mapping and medium, moved to (x, y, z) as a whole. `turned` rotates all of it, including
/// the camera, about that point.
std::string everything_at(double x, double y, double z, double turned = 0, bool fog = true) {
    std::string text = fog ? foggy_room() : room;
    const auto turn = [&](double degrees) { return "Rotate " + std::to_string(degrees) + " 1 2 -1 "; };
    replace(text, "\nCamera", "\n" + turn(-turned) + "Translate " + coordinates(-x, -y, -z) + "\nCamera");
    replace(text, "WorldBegin", "WorldBegin\nTranslate " + coordinates(x, y, z) + turn(turned));
    const std::string away = turn(-turned) + "Translate " + coordinates(-x, -y, -z);
    return text + R"(
Texture "stripes" "spectrum" "checkerboard" "string mapping" "planar" "vector3 v1" [3 0 0] "vector3 v2" [0 3 0.5]
    "rgb tex1" [0.8 0.2 0.1] "rgb tex2" [0.1 0.3 0.9]
Texture "beach" "spectrum" "checkerboard" "integer dimension" 3 "rgb tex1" [0.8 0.7 0.1] "rgb tex2" [0.1 0.3 0.4]
AttributeBegin
  Translate -0.3 1.4 0.1
  Scale 0.1 0.2 0.1
  Texture "ball" "spectrum" "checkerboard" "string mapping" "spherical" "texture tex1" "beach" "rgb tex2" [0.3 0.1 0.3]
  Material "diffuse" "texture reflectance" "ball"
  Shape "sphere" "float radius" 1.2
AttributeEnd
AttributeBegin
  Material "diffuse" "texture reflectance" "stripes"
  ObjectBegin "leaf"
    Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-0.2 0 0 0.2 0 0.1 0.2 0.4 0 -0.2 0.4 0]
      "normal N" [0 0 1 0.2 0 1 0 0.3 1 0 0 1]
    Shape "disk" "float radius" 0.1 "float height" 0.2
  ObjectEnd
AttributeEnd
AttributeBegin
  Translate 0.6 1.2 0.3 Rotate 30 0 1 0
  )" + away +
           "ObjectInstance \"leaf\"\nAttributeEnd\nAttributeBegin\nTranslate -0.6 1.5 -0.4 Scale 0.5 0.7 1\n" + away +
           R"(ObjectInstance "leaf"
AttributeEnd
LightSource "point" "rgb I" [0.3 0.3 0.2] "point3 from" [0.5 1.7 0.5]
LightSource "distant" "rgb L" [0.5 0.4 0.3] "point3 from" [0.2 1 3] "point3 to" [0 0 0]
)";
}

transport::RenderOutput image_of(const std::string& text, std::uint64_t samples) {
    transport::RenderSettings settings;
    settings.samples.per_pixel = samples;
    for (const char* name : {"P", "Pw", "Po", "z", "Nn", "Ngn", "u", "v"}) settings.channels.list.push_back(aov(name));
    return render_of(scene_of(text), settings);
}

/// The number of values of a channel of the first image that differ by more than 64 units in the last place from the
/// second, whose scene is the first one moved by `offset`. The unit is that of the coordinate's terms: the room is 4
/// wide.
std::size_t differences(const transport::RenderOutput& home, const transport::RenderOutput& away, display::ChannelId id,
                        const std::array<double, 3>& offset) {
    const bool world = home.frame_buffer.channels()[static_cast<std::size_t>(id)].name == "Pw";
    const std::vector<double> a = home.frame_buffer.resolve(id), b = away.frame_buffer.resolve(id);
    REQUIRE(a.size() == b.size());
    std::size_t differ = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        if (a[i] == b[i] || (std::isinf(a[i]) && std::isinf(b[i]))) continue;  // outside the room: 0, or infinity
        const double by = world ? offset[i % 3] : 0, ulp = std::ldexp(std::max(4.0, std::abs(by)), -23);
        if (!(std::abs(b[i] - by - a[i]) <= 64 * ulp)) ++differ;
    }
    return differ;
}

}  // namespace

TEST_CASE("a scene a million sizes away from the origin renders like the scene at the origin", "[numerics][geometry]") {
    const auto beauty = [](double x, double y, double z) { return estimate(image_of(everything_at(x, y, z), 16)); };
    const Estimate home = beauty(0, 0, 0);
    const transport::RenderOutput first_hits = image_of(everything_at(0, 0, 0, 0, false), 1);
    for (const double far : {1e3, 2e6}) {
        const std::array<double, 3> offset{far * 1.0001, -0.7 * far, 0.3 * far};
        CAPTURE(far);
        // Seeds are equal: only paths differ that the last bit of a coordinate sends elsewhere, a few of 9216.
        CHECK(deviation(beauty(offset[0], offset[1], offset[2]), home) < 1);
        const auto moved = image_of(everything_at(offset[0], offset[1], offset[2], 0, false), 1);
        for (const auto& channel : first_hits.frame_buffer.channels()) {
            const auto id = static_cast<display::ChannelId>(&channel - first_hits.frame_buffer.channels().data());
            if (id == first_hits.beauty) continue;
            // Of 576 samples one or two may hit another surface, where an edge passes within an ulp.
            CAPTURE(channel.name);
            CHECK(differences(first_hits, moved, id, offset) <= 6);
        }
    }
}

TEST_CASE("a scene turned about a distant point renders like the scene at the origin", "[numerics][geometry]") {
    const Estimate home = estimate(image_of(everything_at(0, 0, 0), 16)),
                   turned = estimate(image_of(everything_at(1e6, -2e6, 5e5, 50), 16));
    INFO(home.mean << " +- " << home.error << " against " << turned.mean << " +- " << turned.error);
    CHECK(deviation(home, turned) < 4.5);
}

TEST_CASE("render space is near the camera and the scene, and exported matrices are those of the world",
          "[geometry][gate]") {
    const transport::SceneDescription near =
        scene_of("LookAt 5 1 1  0 0 0  0 1 0 Camera \"perspective\" WorldBegin Shape \"sphere\" \"float radius\" 1\n");
    CHECK(RenderSpace::of(near).origin == DVec3(1, 1, 1));
    const transport::SceneDescription inside = scene_of(
        "LookAt 0.25 0.5 0.125  0 0 0  0 1 0 Camera \"perspective\" WorldBegin Shape \"sphere\" \"float radius\" 1\n");
    CHECK(RenderSpace::of(inside).origin == DVec3(0.25, 0.5, 0.125));
    const transport::SceneDescription nothing =
        scene_of("LookAt 5e7 1 1  0 0 0  0 1 0 Camera \"perspective\" WorldBegin");
    CHECK(RenderSpace::of(nothing).origin == DVec3(5e7, 1, 1));
    const RenderSpace space{{3e6, -1e6, 0.5}};
    const Transform there = Transform::translate(3e6 + 1, -1e6, 0.5) * Transform::rotate(30, 1, 2, 3);
    const Transform placed = space.placed(there);
    const auto p = placed.point_in_double(there.inverse().point_in_double({3e6, -1e6, 2.5}));
    CHECK(std::abs(p.x) < 1e-9);  // 2^-53 of 3e6
    CHECK(p.z == Approx(2).epsilon(1e-9));
    // Forwards and back: the inverse is that of the moved transform itself, exact to roundings of numbers of size 1.
    const auto q = placed.inverse().point_in_double(placed.point_in_double({0.1, 0.2, 0.3}));
    CHECK(std::abs(q.x - 0.1) < 1e-15);
    CHECK(std::abs(q.z - 0.3) < 1e-15);
    const transport::RenderOutput output = render_of(near);
    const Transform camera = near.camera_to_world;
    for (std::size_t r = 0; r < 4; ++r)
        for (std::size_t c = 0; c < 4; ++c)
            CHECK(output.view.world_to_camera[r][c] == Approx(camera.inverse().matrix()[r][c]).margin(1e-14));
}

TEST_CASE("a vertex beyond float after its transform is an error at its shape", "[law7][geometry]") {
    const transport::SceneDescription scene =
        scene_of("WorldBegin Scale 1e30 1 1\nShape \"trianglemesh\" \"point3 P\" [0 0 0 1e30 0 0 0 1 0]");
    const auto built = transport::BuiltScene::build(scene);
    REQUIRE_FALSE(built.ok());
    CHECK(built.error().line == 2);
    CHECK(import_test::contains(built.error().message, "vertex 1 is not finite after the current transformation"));
    // A face that becomes degenerate at its place is omitted and counted: floats at 1e9 are 64 apart.
    const transport::RenderOutput output = render_of(scene_of(
        "Film \"rgb\" \"integer xresolution\" 2 \"integer yresolution\" 2\nWorldBegin LightSource \"infinite\" "
        "Shape \"sphere\"\nTranslate 1e9 0 0\nShape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0]"));
    REQUIRE(output.warnings.size() == 1);
    CHECK(output.warnings[0].line == 4);
    CHECK(import_test::contains(output.warnings[0].message, "1 of the faces of the mesh have no area in single"));
}
