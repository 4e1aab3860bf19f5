// Scenes made in code: equal to scenes from files, with errors that name the call.
#include <catch2/catch.hpp>

#include <algorithm>
#include <limits>

#include "transport/import/builder/scene_builder.h"
#include "transport/import/pbrt/pbrt_writer.h"
#include "transport/import_support.h"
#include "transport/render/render.h"
#include "transport/scene/scene_hash.h"

using namespace import_test;
using namespace raylex::transport;
using raylex::Result;
using raylex::Status;

namespace {

/// The value of a result that must be a success.
template <typename Value>
Value got(Result<Value> result) {
    if (!result) FAIL(result.error().to_string());
    return std::move(*result);
}
void did(const Status& status) {
    if (!status) FAIL(status.error().to_string());
}

}  // namespace

TEST_CASE("SceneBuilder: a scene made in code equals the scene of a file", "[scene-builder]") {
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
    // Used before it is defined, as files may.
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

TEST_CASE("SceneBuilder: handles of another builder are refused", "[scene-builder]") {
    SceneBuilder here("here"), there("there");
    for (int i = 0; i < 50; ++i) got(there.add_material("conductor", {}));
    const MaterialHandle material = got(there.add_material("diffuse", {}));
    const AreaLightHandle light = got(there.add_area_light("diffuse", {}));
    const MediumHandle medium = got(there.add_medium("fog", "homogeneous", {}));
    const ObjectHandle object = got(there.add_object("thing"));
    // The local handles have the same numbers.
    got(here.add_material("diffuse", {}));
    got(here.add_area_light("diffuse", {}));
    got(here.add_medium("fog", "homogeneous", {}));
    got(here.add_object("thing"));
    const auto refused = [](const auto& result, const std::string& what) {
        REQUIRE_FALSE(result.ok());
        INFO(result.error().message);
        CHECK(contains(result.error().message, "the " + what + " belongs to another scene builder"));
        CHECK(contains(result.error().file, "scene_builder_test.cpp"));
    };
    refused(here.add_shape("sphere", {}, {.material = material}), "material");
    refused(here.add_shape("sphere", {}, {.area_light = light}), "area light");
    refused(here.add_shape("sphere", {}, {.inside = medium}), "medium inside");
    refused(here.add_shape("sphere", {}, {.outside = medium}), "medium outside");
    refused(here.add_shape("sphere", {}, {.object = object}), "object");
    refused(here.add_shape("sphere", {}, {.moved_to = Transform::translate(1, 0, 0), .material = material}),
            "material");
    refused(
        here.add_mesh({.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, .indices = {0, 1, 2}}, {.material = material}),
        "material");
    refused(here.add_curves({.points = {}, .first_points = {}, .widths = {}}, {.area_light = light}), "area light");
    refused(here.add_instance(object), "object");
    refused(here.add_moving_instance(object, {}, Transform::translate(1, 0, 0)), "object");
    refused(here.set_camera("perspective", {}, Transform::translate(0, 0, 1), medium), "medium");
    const auto invented = here.add_shape("sphere", {}, {.material = {.reference = 1}});
    REQUIRE_FALSE(invented.ok());
    CHECK(contains(invented.error().message, "that no scene builder returned"));
    did(here.add_shape("sphere", {}, {.material = here.material_named("late")}));
    got(here.add_named_material("late", "diffuse", {}));
    // A moved builder keeps its handles.
    SceneBuilder moved(std::move(there));
    did(moved.add_shape("sphere", {}, {.material = material, .area_light = light, .inside = medium}));
    did(moved.add_instance(object));
    CHECK(got(moved.finish()).shapes.size() == 1);
    CHECK(got(here.finish()).shapes.size() == 1);
}

TEST_CASE("SceneBuilder: finish() can be called once, and is the last call", "[scene-builder]") {
    SceneBuilder scene("code");
    const ObjectHandle object = got(scene.add_object("thing"));
    got(scene.add_named_material("red", "diffuse", {}));
    did(scene.add_shape("sphere", {}, {.material = scene.material_named("rad")}));
    const auto refused = [](const auto& result) {
        REQUIRE_FALSE(result.ok());
        CHECK(contains(result.error().message, "the scene builder is spent; expected a new one"));
    };
    const auto first = scene.finish();  // no material 'rad'
    REQUIRE_FALSE(first.ok());
    CHECK(contains(first.error().message, "rad"));
    refused(scene.finish());
    SceneBuilder whole("code");
    const ObjectHandle part = got(whole.add_object("thing"));
    got(whole.add_named_material("red", "diffuse", {}));
    got(whole.finish());
    refused(whole.finish());
    refused(whole.add_named_material("red", "diffuse", {}));
    refused(whole.add_shape("sphere", {}, {.object = part}));
    refused(whole.add_object("thing"));
    refused(whole.add_instance(part));
    refused(scene.add_instance(object));
}

TEST_CASE("SceneBuilder: values that are not finite are refused by name", "[scene-builder]") {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN(), infinite = std::numeric_limits<double>::infinity();
    SceneBuilder scene("code");
    const auto refused = [](const auto& result, const std::string& part) {
        REQUIRE_FALSE(result.ok());
        INFO(result.error().message);
        CHECK(contains(result.error().message, part));
        CHECK(contains(result.error().file, "scene_builder_test.cpp"));
    };
    refused(scene.set_camera("perspective", {typed::real("fov", nan)}, {}), "parameter 'fov' is not a number");
    refused(scene.add_area_light("diffuse", {typed::real("power", infinite)}), "parameter 'power' is infinite");
    refused(scene.add_material("diffuse", {typed::rgb("reflectance", {0, nan, 0})}),
            "value 1 of parameter 'reflectance' is not a number");
    refused(scene.add_shape("sphere", {typed::real("radius", 1e300)}),
            "parameter 'radius' is beyond the range of float");
    refused(scene.set_sampler("halton", {typed::integer("pixelsamples", std::int64_t{1} << 40)}),
            "is 1099511627776; expected an integer of 32 bits");
    refused(scene.set_sampler("halton", {typed::numbers("pixelsamples", raylex::ParameterType::integer, {1.5})}),
            "of 32 bits");
    refused(scene.set_sampler("halton", {typed::numbers("pixelsamples", raylex::ParameterType::integer, {})}),
            "has no values");
    refused(scene.add_light("point", {typed::numbers("I", raylex::ParameterType::rgb, {1, 2})}),
            "has 2 numbers; expected 3");
    raylex::Parameter mixed = typed::text("filename", "x");
    mixed.numbers = {1};
    refused(scene.add_light("infinite", {mixed}), "has values of another kind; expected text");
    refused(scene.set_transform_times(-infinite, 1), "expected finite ones");
    refused(scene.set_transform_times(0, infinite), "expected finite ones");
    refused(scene.scale_displacement_edges(infinite), "finite");
    const std::vector<StoredVec3> triangle{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    refused(
        scene.add_mesh({.positions = {{0, 0, 0}, {1, 0, 0}, {0, static_cast<float>(nan), 0}}, .indices = {0, 1, 2}}),
        "position 2 of the mesh is not finite");
    Matrix4 broken = Transform().matrix();
    broken[0][3] = nan;
    refused(scene.add_mesh({.positions = triangle, .indices = {0, 1, 2}}, {.to_world = Transform(broken)}),
            "not finite");
    refused(scene.add_light("point", {}, Transform(broken)), "not finite");
    refused(scene.set_camera("perspective", {}, Transform(broken)), "not finite");
    refused(scene.add_instance(got(scene.add_object("thing")), Transform(broken)), "not finite");
    // Invalid texture coordinates are repaired like those of mesh files.
    const float none = static_cast<float>(nan);
    did(scene.add_mesh({.positions = triangle,
                        .indices = {0, 1, 2},
                        .uvs = {{0.25f, 0.5f}, {none, 1}, {1, static_cast<float>(infinite)}}}));
    const SceneDescription made = got(scene.finish());
    REQUIRE(made.shapes.size() == 1);
    CHECK(made.shapes[0].uvs[0].y == 0.5f);
    for (const std::size_t i : {1U, 2U}) CHECK((made.shapes[0].uvs[i].x == 0 && made.shapes[0].uvs[i].y == 0));
    REQUIRE(made.warnings.size() == 1);
    CHECK(contains(made.warnings[0].message, "2 of the texture coordinates of the mesh are not finite"));
}

TEST_CASE("SceneBuilder: numbers are written with the types that pbrt reads", "[scene-builder]") {
    using T = raylex::ParameterType;
    SceneBuilder scene("code");
    did(scene.set_film(
        "rgb", {typed::integer("xresolution", 4), typed::integer("yresolution", 4), typed::integer("iso", 200)}));
    did(scene.set_camera("perspective", {typed::integer("fov", 40), typed::integer("shutterclose", 1)},
                         Transform::look_at({0, 0, 4}, {0, 0, 0}, {0, 1, 0})));
    const MediumHandle fog = got(scene.add_medium("fog", "homogeneous", {typed::real("sigma_s", 2)}));
    did(scene.add_texture("half", TextureValue::real, "constant", {typed::integer("value", 1)}));
    did(scene.add_texture("grey", TextureValue::spectrum, "constant", {typed::real("value", 0.5)}));
    did(scene.add_texture("mixed", TextureValue::spectrum, "mix",
                          {typed::real("tex1", 0.25), typed::integer("tex2", 1), typed::real("amount", 0.5)}));
    did(scene.add_light("infinite", {typed::real("L", 3), typed::integer("scale", 2)}));
    const MaterialHandle grey = got(scene.add_material("diffuse", {typed::real("reflectance", 0.5)}));
    const MaterialHandle metal = got(scene.add_material("conductor", {typed::real("eta", 1.5), typed::real("k", 2)}));
    const MaterialHandle bright = got(scene.add_material("diffuse", {typed::real("reflectance", 1.5)}));
    got(scene.add_material("dielectric", {typed::integer("eta", 2)}));
    did(scene.add_shape("sphere", {typed::integer("radius", 1), typed::integer("alpha", 1)}, {.material = grey}));
    did(scene.add_shape("sphere", {typed::integer("radius", 2)}, {.material = metal, .inside = fog}));
    did(scene.add_shape("disk", {}, {.to_world = Transform::translate(0, 0, -3), .material = bright}));
    SceneDescription made = got(scene.finish());
    const std::string text = pbrt_text(made).text;
    for (const char* part :
         {"\"float fov\" [ 40 ]", "\"float shutterclose\"", "\"float iso\"", "\"integer xresolution\"",
          "\"rgb sigma_s\" [ 2 2 2 ]", "\"half\" \"float\" \"constant\" \"float value\" [ 1 ]",
          "\"grey\" \"spectrum\" \"constant\" \"rgb value\" [ 0.5 0.5 0.5 ]", "\"rgb tex1\" [ 0.25 0.25 0.25 ]",
          "\"rgb tex2\" [ 1 1 1 ]", "\"float amount\" [ 0.5 ]", "\"rgb L\" [ 3 3 3 ]", "\"float scale\" [ 2 ]",
          "\"rgb reflectance\" [ 0.5 0.5 0.5 ]", "\"rgb eta\" [ 1.5 1.5 1.5 ]", "\"float eta\" [ 2 ]",
          "\"float reflectance\" [ 1.5 ]", "\"float radius\" 2"}) {
        INFO(part << " in\n" << text);
        CHECK(contains(text, part));
    }
    // The image has the same bits as with the numbers themselves.
    const auto image = [](const SceneDescription& of) {
        RenderSettings settings;
        settings.samples.per_pixel = 4;
        settings.machine.threads = 1;
        const auto output = got(render(of, settings));
        return output.frame_buffer.resolve(output.beauty);
    };
    const std::vector<double> colors = image(made);
    std::size_t numbers = 0;
    const auto undo = [&](raylex::ParameterSet& set) {
        for (raylex::Parameter& each : set.parameters) {
            if (each.type != T::rgb || each.numbers[0] != each.numbers[1] || each.numbers[1] != each.numbers[2])
                continue;
            each.type = T::real;
            each.numbers.resize(1);
            ++numbers;
        }
    };
    for (std::size_t i = 1; i < made.materials.size(); ++i) undo(made.materials[i].parameters);
    for (auto& each : made.textures) undo(each.parameters);
    for (auto& each : made.media) undo(each.parameters);
    for (auto& each : made.lights) undo(each.parameters);
    CHECK(numbers == 8);
    CHECK((image(made) == colors));
    CHECK(*std::max_element(colors.begin(), colors.end()) > 0);
}

TEST_CASE("SceneBuilder: lists of text, points, vectors and normals", "[scene-builder]") {
    SceneBuilder scene("code");
    got(scene.add_named_material("red", "diffuse", {typed::rgb("reflectance", {1, 0, 0})}));
    got(scene.add_named_material("blue", "diffuse", {typed::rgb("reflectance", {0, 0, 1})}));
    got(scene.add_material("mix", {typed::texts("materials", {"red", "blue"}), typed::real("amount", 0.25)}));
    did(scene.add_texture("stripes", TextureValue::real, "checkerboard",
                          {typed::text("mapping", "planar"), typed::vector3("v1", {4, 0, 0})}));
    raylex::Parameter points = typed::point3("P", {0, 0, 0});
    points.numbers = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    raylex::Parameter normals = typed::normal("N", {0, 0, 1}), uvs = typed::point2("uv", {0, 1});
    normals.numbers = {0, 0, 1, 0, 0, 1, 0, 0, 1};
    uvs.numbers = {0, 0, 1, 0, 0, 1};
    did(scene.add_shape("trianglemesh", {points, normals, uvs}));
    CHECK(typed::vector2("v", {1, 2}).type == raylex::ParameterType::vector2);
    const SceneDescription made = got(scene.finish());
    REQUIRE(made.shapes.size() == 1);
    CHECK(made.shapes[0].normals.size() == 3);
    CHECK(made.shapes[0].uvs.size() == 3);
    const SceneDescription twin = scene_of(pbrt_text(made).text);
    CHECK(scene_hash(twin) == scene_hash(made));
    CHECK(twin.materials.back().parameters.find("materials")->strings == std::vector<std::string>{"red", "blue"});
}
