// Scenes made in code: the same as files say them, with errors that name the call.
#include <catch2/catch.hpp>

#include "transport/import_support.h"
#include "transport/render/render.h"
#include "transport/scene/builder/scene_builder.h"
#include "transport/scene/scene_hash.h"

using namespace import_test;
using namespace raylex::transport;
using raylex::Result;
using raylex::Status;

namespace {

/// The value of what must have worked.
template <typename Value>
Value got(Result<Value> result) {
    if (!result) FAIL(result.error().to_string());
    return std::move(*result);
}
void did(const Status& status) {
    if (!status) FAIL(status.error().to_string());
}

}  // namespace

TEST_CASE("SceneBuilder: a scene in code is the scene that a file says", "[scene-builder]") {
    const SceneDescription from_file = scene_of(R"(
        Film "rgb" "integer xresolution" 8 "integer yresolution" 6
        Sampler "halton" "integer pixelsamples" 4
        Integrator "path" "integer maxdepth" 3
        MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_s" [0.1 0.2 0.3]
        MediumInterface "" "fog"
        LookAt 0 0 4  0 0 0  0 1 0
        Camera "perspective" "float fov" 40
        WorldBegin
        Texture "checks" "spectrum" "checkerboard" "float uscale" 4
        LightSource "point" "rgb I" [3 3 3]
        MakeNamedMaterial "floor" "string type" "diffuse" "texture reflectance" "checks"
        ObjectBegin "ball"
        NamedMaterial "floor"
        Shape "sphere" "float radius" 0.5
        ObjectEnd
        AttributeBegin
        AreaLightSource "diffuse" "rgb L" [1 2 3]
        ReverseOrientation
        Translate 0 2 0
        Shape "disk" "float radius" 0.25
        AttributeEnd
        Translate 1 0 0
        ObjectInstance "ball"
    )");
    SceneBuilder scene("code");
    did(scene.set_film("rgb", {typed::integer("xresolution", 8), typed::integer("yresolution", 6)}));
    did(scene.set_sampler("halton", {typed::integer("pixelsamples", 4)}));
    did(scene.set_integrator("path", {typed::integer("maxdepth", 3)}));
    const MediumHandle fog = got(scene.add_medium("fog", "homogeneous", {typed::rgb("sigma_s", {0.1, 0.2, 0.3})}));
    did(scene.set_camera("perspective", {typed::real("fov", 40)}, Transform::look_at({0, 0, 4}, {0, 0, 0}, {0, 1, 0}),
                         fog));
    did(scene.add_texture("checks", TextureValue::spectrum, "checkerboard", {typed::real("uscale", 4)}));
    did(scene.add_light("point", {typed::rgb("I", {3, 3, 3})}));
    const ObjectHandle ball = got(scene.add_object("ball"));
    // Before it is defined, as files may.
    did(scene.add_shape("sphere", {typed::real("radius", 0.5)},
                        {.material = scene.material_named("floor"), .outside = fog, .object = ball}));
    got(scene.add_named_material("floor", "diffuse", {typed::texture("reflectance", "checks")}));
    const AreaLightHandle lamp = got(scene.add_area_light("diffuse", {typed::rgb("L", {1, 2, 3})}));
    did(scene.add_shape(
        "disk", {typed::real("radius", 0.25)},
        {.to_world = Transform::translate(0, 2, 0), .area_light = lamp, .outside = fog, .reverse_orientation = true}));
    did(scene.add_instance(scene.object_named("ball"), Transform::translate(1, 0, 0)));
    CHECK(scene_hash(got(scene.finish())) == scene_hash(from_file));
}

TEST_CASE("SceneBuilder: meshes, groups and labels", "[scene-builder]") {
    SceneBuilder scene("code");
    const AreaLightHandle lamp = got(scene.add_area_light("diffuse", {}, "key"));
    did(scene.add_mesh({.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, .indices = {0, 1, 2}},
                       {.area_light = lamp, .label = "lamp"}));
    did(scene.add_light("infinite", {}, {}, "sky"));
    const SceneDescription made = got(scene.finish());
    REQUIRE(made.shapes.size() == 1);
    CHECK(made.shapes[0].label == "lamp");
    CHECK(made.area_lights[0].group == "key");
    CHECK(made.lights[0].group == "sky");
}

TEST_CASE("SceneBuilder: errors name the call", "[scene-builder]") {
    SceneBuilder scene("code");
    const auto refused = [](const auto& result, int line, const std::string& part) {
        REQUIRE_FALSE(result.ok());
        const raylex::Error& error = result.error();
        CHECK(contains(error.file, "scene_builder_test.cpp"));
        CHECK(error.line == line);
        INFO(error.message);
        CHECK(contains(error.message, part));
    };
    refused(scene.add_material("diffuse", {typed::real("reflectence", 1)}), __LINE__, "has no parameter 'reflectence'");
    refused(scene.add_shape("sphere", {typed::real("radius", -1)}), __LINE__, "radius is not above 0");
    refused(scene.add_light("point", {}, Transform::scale(0, 1, 1)), __LINE__, "cannot be inverted");
    refused(scene.add_mesh({.positions = {{0, 0, 0}}, .indices = {0, 1, 2}}), __LINE__, "index 1 is out of range");
    refused(scene.add_instance({}), __LINE__, "an instance of no object");
    refused(scene.add_texture("t", TextureValue::real, "imagemap", {typed::text("filename", "no-such.png")}), __LINE__,
            "no-such.png");
    got(scene.add_named_material("red", "diffuse", {}));
    refused(scene.add_named_material("red", "diffuse", {}), __LINE__, "material 'red' is defined twice");
    const int line = __LINE__ + 1;
    did(scene.add_shape("sphere", {}, {.material = scene.material_named("rad")}));
    const auto finished = scene.finish();
    refused(finished, line, "no material is called 'rad'");
    CHECK(contains(finished.error().hint, "did you mean 'red'?"));
}
