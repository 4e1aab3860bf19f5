// Light in scenes with motion: integrators compared with one another, threads, files, errors.
#include "tests/transport/replicates.h"
#include "transport/import/builder/scene_builder.h"
#include "transport/import/pbrt/pbrt_importer.h"
#include "transport/import/pbrt/pbrt_writer.h"
#include "transport/scene/effects/effects.h"
#include "transport/scene/scene_hash.h"

using namespace render_test;

namespace {

/// A camera with a lens that comes nearer, turns and zooms (its transform scales); a ball that moves as a shape; a
/// glossy box and a curve that turn as an instance; a moving cutout; three kinds of lights. The curve is not near the
/// box: rays that leave a curve start behind it, so paths there depend on their direction.
const std::string moving_room = plain_film + R"(
PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
TransformTimes 0.1 0.9
ActiveTransform StartTime
LookAt 0 1 4.2  0 1 0  0 1 0
ActiveTransform EndTime
Scale 1.2 1.1 1
LookAt 0.5 1.3 3.7  0 1 0  0.1 1 0
ActiveTransform All
Camera "perspective" "float fov" 42 "float lensradius" 0.05 "float focaldistance" 4 "float shutterclose" 0.8
WorldBegin
Material "diffuse" "rgb reflectance" [0.7 0.6 0.5]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-2 0 2 2 0 2 2 0 -1 -2 0 -1]
Shape "bilinearmesh" "point3 P" [-2 0 -1 2 0 -1 -2 3 -1 2 3 -1]
LightSource "point" "rgb I" [3 3 3] "point3 from" [-1 2.5 1]
LightSource "infinite" "rgb L" [0.2 0.25 0.3]
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [8 7 6]
  Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-0.4 2.8 -0.4 0.4 2.8 -0.4 0.4 2.8 0.4 -0.4 2.8 0.4]
AttributeEnd
AttributeBegin
  Material "diffuse" "rgb reflectance" [0.3 0.7 0.3]
  ActiveTransform StartTime
  Translate -1 0.5 0.2
  ActiveTransform EndTime
  Translate 0.2 1.1 0.4
  Scale 1.3 0.8 1
  ActiveTransform All
  Shape "sphere" "float radius" 0.4
AttributeEnd
ObjectBegin "box"
  Material "conductor" "rgb reflectance" [0.8 0.7 0.6] "float roughness" 0.2
  Shape "trianglemesh" "integer indices" [0 1 2 0 2 3 4 6 5 4 7 6 0 4 5 0 5 1 3 2 6 3 6 7 0 3 7 0 7 4 1 5 6 1 6 2]
    "point3 P" [-0.3 -0.3 -0.3 0.3 -0.3 -0.3 0.3 0.3 -0.3 -0.3 0.3 -0.3
      -0.3 -0.3 0.3 0.3 -0.3 0.3 0.3 0.3 0.3 -0.3 0.3 0.3]
  Material "diffuse" "rgb reflectance" [0.6 0.5 0.2]
  Shape "curve" "string type" "cylinder" "point3 P" [0 0.6 0 0.2 0.8 0 -0.2 1 0 0 1.2 0] "float width" 0.12
ObjectEnd
AttributeBegin
  Translate 0.9 0.6 0.3
  ActiveTransform EndTime
  Rotate 80 0.2 1 0.1
  ActiveTransform All
  ObjectInstance "box"
AttributeEnd
AttributeBegin
  Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
  ActiveTransform EndTime
  Translate 0.6 0 0
  ActiveTransform All
  Shape "bilinearmesh" "point3 P" [-0.6 0.2 1 0.1 0.2 1 -0.6 0.9 1 0.1 0.9 1] "float alpha" 0.5
AttributeEnd
)";

transport::RenderSettings few_bounces() {
    transport::RenderSettings settings;
    settings.paths.max_depth = 3;
    settings.samples.per_pixel = 256;
    return settings;
}

}  // namespace

TEST_CASE("motion: bidirectional path tracing agrees with path tracing", "[motion][bdpt][render][statistical][gate]") {
    compare_with_path(
        moving_room, few_bounces(), integrator_named("bdpt"), 12, 128,
        {"C<RD>L", "C<RD>B", "C<RD><RD>+[LB]", "C<RD><RG>.*[LB]", "C<RG>.*[LB]", "C<Ts><RD>[LB]", "C.*[LB]"});
}

TEST_CASE("motion: light tracing agrees with path tracing", "[motion][light-tracer][render][statistical][gate]") {
    compare_with_path(moving_room, few_bounces(), integrator_named("lighttracer"), 12, 512,
                      {"C<RD>L", "C<RD>B", "C<RD><RD>+[LB]", "C<RD><RG>.*[LB]", "C<RG>.*[LB]", "C.*[LB]"});
}

TEST_CASE("motion: Metropolis light transport agrees with path tracing",
          "[motion][pssmlt][render][statistical][gate]") {
    compare_with_path(moving_room, few_bounces(), metropolis(100, 20'000), 12, 128, {"C<RD>L", "C.*[LB]"});
}

TEST_CASE("motion: the image does not depend on the number of threads", "[motion][render][law3]") {
    const transport::SceneDescription scene = scene_of(moving_room);
    for (const char* integrator : {"path", "bdpt", "lighttracer"}) {
        CAPTURE(integrator);
        transport::RenderSettings settings;
        settings.samples.per_pixel = 8;
        settings.paths.integrator = integrator_named(integrator);
        settings.machine.threads = 1;
        const transport::RenderOutput one = render_of(scene, settings);
        settings.machine.threads = 3;
        const transport::RenderOutput three = render_of(scene, settings);
        CHECK((one.frame_buffer.resolve(one.beauty) == three.frame_buffer.resolve(three.beauty)));
    }
}

TEST_CASE("motion: rays leave moving shapes as they leave fixed ones", "[motion][render]") {
    // In a closed furnace, a sphere of radiance 1 that turns, moves and is stretched, every path of any length
    // contributes 1. A ray that hits the surface that it left, or passes through it, would not.
    const std::string text = plain_film + R"(
Camera "perspective" "float fov" 60
WorldBegin
LightSource "infinite" "rgb L" [1 1 1]
AttributeBegin
  Material "diffuse" "rgb reflectance" [1 1 1]
  ActiveTransform StartTime
  Translate 1000 -2000 3
  Rotate 20 1 2 3
  ActiveTransform EndTime
  Translate 1001 -2000 4
  Scale 1.5 1 0.7
  Rotate 170 3 -1 1
  ActiveTransform All
  Shape "sphere" "float radius" 1
  Shape "trianglemesh" "integer indices" [0 1 2 0 2 3 0 1 3]
    "point3 P" [-1.5 0 0 1.5 0.1 0 1.5 0 0.4 -1.5 0.2 0.5]
AttributeEnd
)";
    std::string camera = text;
    camera.replace(camera.find("Camera"), 0, "LookAt 1000 -2000 -3  1000.5 -2000 3.5  0 1 0\n");
    transport::RenderSettings settings;
    settings.paths.max_depth = 40;
    settings.samples.per_pixel = 64;
    settings.paths.integrator = path_with(flag_parameter("roulette", false));
    const transport::RenderOutput output = render_of(scene_of(camera), settings);
    const std::vector<double> image = output.frame_buffer.resolve(output.beauty);
    // A path of albedo 1 that ends contributes exactly 1. Paths longer than 40 contribute less, which is rare outside.
    // A wrong self-intersection of one ray in a thousand would lose light in a mean of a hundred thousand bounces.
    double sum = 0;
    for (const double value : image) sum += value / static_cast<double>(image.size());
    CHECK(sum <= 1 + 1e-6);
    CHECK(sum >= 1 - 1e-3);
}

TEST_CASE("motion: scenes with motion are read from files unchanged", "[motion][pbrt-writer]") {
    const import_test::Folder folder;
    const transport::SceneDescription scene = scene_of(moving_room);
    const auto written = transport::write_pbrt(scene, folder.path("again.pbrt"));
    REQUIRE(written.ok());
    CHECK(written->empty());
    auto twin = transport::import_pbrt(folder.path("again.pbrt"));
    INFO((twin ? std::string() : twin.error().to_string()));
    REQUIRE(twin.ok());
    CHECK(twin->moved_to.size() == 3);
    CHECK(transport::scene_hash(*twin) == transport::scene_hash(scene));
    // The motion is part of the scene's hash.
    transport::SceneDescription other = scene_of(moving_room);
    other.moved_to[1] = other.moved_to[0];
    CHECK(transport::scene_hash(other) != transport::scene_hash(scene));
}

TEST_CASE("motion: scenes made in code equal those of files", "[motion][scene-builder]") {
    namespace typed = raylex::transport::typed;  // other tests have a real() of their own
    using transport::Transform;
    const Transform view = Transform::translate(0, 0, 5), later = Transform::translate(0.5, 0, 4);
    const Transform here = Transform::translate(1, 2, 3), there = Transform::rotate(30, 0, 1, 0);
    transport::SceneBuilder scene("made.pbrt");
    REQUIRE(scene.set_transform_times(0.25, 0.75).ok());
    REQUIRE(scene.set_moving_camera("perspective", {typed::real("shutterclose", 0.5)}, view, later).ok());
    REQUIRE(scene.add_shape("sphere", {typed::real("radius", 2)}, {.to_world = here, .moved_to = there}).ok());
    const auto object = scene.add_object("ball");
    REQUIRE(object.ok());
    REQUIRE(scene.add_shape("sphere", {}, {.object = *object}).ok());
    REQUIRE(scene.add_moving_instance(*object, there, here).ok());
    auto made = scene.finish();
    REQUIRE(made.ok());
    const transport::SceneDescription read = scene_of(R"(
TransformTimes 0.25 0.75
ActiveTransform StartTime Translate 0 0 5 ActiveTransform EndTime Translate 0.5 0 4 ActiveTransform All
Camera "perspective" "float shutterclose" 0.5
WorldBegin
AttributeBegin
ActiveTransform StartTime Translate 1 2 3 ActiveTransform EndTime Rotate 30 0 1 0 ActiveTransform All
Shape "sphere" "float radius" 2
AttributeEnd
ObjectBegin "ball" Shape "sphere" ObjectEnd
ActiveTransform StartTime Rotate 30 0 1 0 ActiveTransform EndTime Translate 1 2 3 ActiveTransform All
ObjectInstance "ball"
)");
    CHECK(transport::scene_hash(*made) == transport::scene_hash(read));
    CHECK(made->moved_to.size() == 2);
    const auto backwards = scene.set_transform_times(1, 0);
    REQUIRE_FALSE(backwards.ok());
    CHECK(import_test::contains(backwards.error().message, "expected the earlier one first"));
}

TEST_CASE("motion: one warning at its position for objects that pbrt does not move either", "[motion][law7]") {
    const transport::SceneDescription scene = scene_of(
        "WorldBegin\nActiveTransform EndTime Translate 1 0 0 ActiveTransform All\nLightSource \"point\"\n"
        "Texture \"t\" \"float\" \"checkerboard\"\n");
    REQUIRE(scene.warnings.size() == 2);
    CHECK(import_test::contains(scene.warnings[0].to_string(), ":3:1"));
    CHECK(import_test::contains(scene.warnings[0].message, "lights under a moving transformation stand still"));
    CHECK(import_test::contains(scene.warnings[1].message, "textures under a moving transformation stand still"));
}
