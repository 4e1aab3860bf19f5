// Builds scenes from arrays: transport/import/builder/scene_builder.h with Python values as parameters.
#include "experiments/python/bindings/scenes/scene_builder.h"

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cmath>
#include <optional>

#include "experiments/python/bindings/scenes/scene.h"
#include "transport/media/medium_parameters.h"

namespace raylex::python {

using namespace pybind11::literals;
using transport::EntityKind;
using transport::SceneBuilder;

transport::MediumHandle medium_of(SceneBuilder& scene, const py::object& medium, const char* what) {
    if (medium.is_none()) return {};
    if (py::isinstance<py::str>(medium)) return scene.medium_named(medium.cast<std::string>(), caller());
    if (py::isinstance<transport::MediumHandle>(medium)) return medium.cast<transport::MediumHandle>();
    fail_here(std::string(what) + " is " + shown(medium) +
              "; expected a Medium from SceneBuilder.medium(), its name, or None for vacuum");
}

namespace {

using Point = std::array<double, 3>;

std::unique_ptr<Builder> make_builder(const std::string& name, const std::optional<std::filesystem::path>& folder,
                                      const std::string& missing_files, const std::string& color_space) {
    transport::SearchPath search;
    if (folder) search = {*folder, *folder};
    auto builder = std::make_unique<Builder>(name, search);
    if (missing_files == "placeholders") builder->scene.set_missing_files(transport::MissingFiles::placeholders);
    else if (missing_files != "refused")
        fail_here("missing_files is '" + missing_files + "'; expected 'refused' or 'placeholders'");
    constexpr std::pair<const char*, transport::ColorSpace> spaces[] = {
        {"srgb", transport::ColorSpace::srgb},
        {"dci-p3", transport::ColorSpace::dci_p3},
        {"rec2020", transport::ColorSpace::rec2020},
        {"aces2065-1", transport::ColorSpace::aces2065_1}};
    for (const auto& [word, space] : spaces)
        if (color_space == word) {
            builder->scene.set_color_space(space);
            return builder;
        }
    fail_here("color_space is '" + color_space + "'; expected srgb, dci-p3, rec2020 or aces2065-1");
}

transport::Transform view_of(const Point& eye, const Point& look, const Point& up) {
    for (const auto& [what, point] : {std::pair("eye", &eye), std::pair("look", &look), std::pair("up", &up)})
        for (const double x : *point)
            if (!std::isfinite(x))
                fail_here(std::string(what) + " has " + std::to_string(x) + "; expected finite numbers");
    const transport::Transform view = transport::Transform::look_at(eye, look, up);
    if (!view.invertible())
        fail_here("'up' is parallel to the direction of view, or eye and look are equal; expected another direction");
    return view;
}

py::array look_at(const Point& eye, const Point& look, const Point& up) {
    const transport::Transform view = view_of(eye, look, up);
    std::vector<double> values;
    for (const auto& row : view.matrix()) values.insert(values.end(), row.begin(), row.end());
    return owning_array(std::move(values), {4, 4});
}

void set_camera(Builder& self, const std::string& type, const std::optional<Point>& eye,
                const std::optional<Point>& look, const Point& up, const py::object& world_to_camera,
                const py::object& moved_to, const py::object& medium, const py::object& parameters,
                const py::kwargs& keywords) {
    SceneBuilder& scene = self.open();
    if (eye.has_value() != look.has_value() || eye.has_value() != world_to_camera.is_none())
        fail_here(
            "the camera's position is missing or given twice; expected either 'eye' and 'look' or 'world_to_camera'");
    const transport::Transform view = eye ? view_of(*eye, *look, up) : transform_of(world_to_camera, "world_to_camera");
    const transport::MediumHandle around = medium_of(scene, medium, "medium");
    transport::SceneParameters given = parameters_of(EntityKind::camera, type, parameters, keywords);
    if (const auto last = transform_or_none(moved_to, "moved_to"))
        take(scene.set_moving_camera(type, std::move(given), view, *last, around, caller()));
    else take(scene.set_camera(type, std::move(given), view, around, caller()));
}

void add_settings(py::class_<Builder>& builder) {
    using Setter = Status (SceneBuilder::*)(const std::string&, transport::SceneParameters, const SourceLocation&);
    const auto add = [&](const char* name, Setter setter, EntityKind kind, const char* help) {
        builder.def(
            name,
            [setter, kind](Builder& self, const std::string& type, const py::object& parameters,
                           const py::kwargs& keywords) {
                take((self.open().*setter)(type, parameters_of(kind, type, parameters, keywords), caller()));
            },
            "type"_a, py::kw_only(), "parameters"_a = py::none(), help);
    };
    add("film", &SceneBuilder::set_film, EntityKind::film, "film('rgb', xresolution=640, yresolution=480): pixels.");
    add("filter", &SceneBuilder::set_filter, EntityKind::pixel_filter, "filter('gaussian', xradius=1.5): pixels.");
    add("sampler", &SceneBuilder::set_sampler, EntityKind::sampler, "sampler('independent', pixelsamples=16)");
    add("integrator", &SceneBuilder::set_integrator, EntityKind::integrator, "integrator('path', maxdepth=5)");
    builder.def("camera", &set_camera, "type"_a, py::kw_only(), "eye"_a = py::none(), "look"_a = py::none(),
                "up"_a = Point{0, 1, 0}, "world_to_camera"_a = py::none(), "moved_to"_a = py::none(),
                "medium"_a = py::none(), "parameters"_a = py::none(),
                "camera('perspective', eye=(0, 0, 4), look=(0, 0, 0), fov=40): world units, fov in degrees of the "
                "shorter side.\n"
                "Instead of eye and look, world_to_camera is a (4, 4) matrix from look_at(): in camera space x points "
                "right, y up\nand z along the view. moved_to is another one, where the camera is at the end of "
                "transform_times().\n"
                "medium is the medium around the camera: a Medium or its name. Errors: a position given twice or "
                "missing, a matrix without\nan inverse.");
    builder.def_static("look_at", &look_at, "eye"_a, "look"_a, "up"_a = Point{0, 1, 0},
                       "Returns the (4, 4) matrix from world to camera, for world_to_camera and moved_to of camera(). "
                       "Errors: 'up' parallel\nto the direction of view.");
    builder.def(
        "transform_times",
        [](Builder& self, double start, double end) { take(self.open().set_transform_times(start, end, caller())); },
        "start"_a, "end"_a,
        "Start and end time of objects with moved_to, on the clock of the camera's shutteropen and "
        "shutterclose;\n"
        "0 and 1 by default. Errors: times that are not finite or not increasing.");
    builder.def(
        "disable_texture_filtering", [](Builder& self) { self.open().disable_texture_filtering(); },
        "Reads all images without filtering, whatever the 'filter' of their textures.");
    builder.def(
        "scale_displacement_edges",
        [](Builder& self, double factor) { take(self.open().scale_displacement_edges(factor, caller())); }, "factor"_a,
        "Multiplies the 'edgelength' of all displaced meshes; a factor below 1 is finer. Errors: a factor that is not "
        "above 0.");
}

transport::MaterialHandle add_material(Builder& self, const std::string& type, const std::string& name,
                                       const py::object& parameters, const py::kwargs& keywords) {
    SceneBuilder& scene = self.open();
    transport::SceneParameters given = parameters_of(EntityKind::material, type, parameters, keywords);
    // pbrt's parameter of the same name selects a measured medium. A name of such a medium here is probably meant as
    // that.
    const bool preset = type == "subsurface" && given.own.find("name") == nullptr;
    if (preset && transport::measured_coefficients(name, {}).ok())
        fail_here("name='" + name + "' would name the material instead of choosing the measured medium",
                  "expected parameters={'name': '" + name + "'} for the medium, or another name for the material");
    return take(name.empty() ? scene.add_material(type, std::move(given), caller())
                             : scene.add_named_material(name, type, std::move(given), caller()));
}

void add_texture(Builder& self, const std::string& name, const std::string& value, const std::string& type,
                 const py::object& to_world, const py::object& parameters, const py::kwargs& keywords) {
    if (value != "float" && value != "spectrum")
        fail_here("a texture is 'float' or 'spectrum', not '" + value + "'; expected one of them as second argument");
    const auto kind = value == "float" ? transport::TextureValue::real : transport::TextureValue::spectrum;
    take(self.open().add_texture(name, kind, type, parameters_of(EntityKind::texture, type, parameters, keywords),
                                 transform_of(to_world, "to_world"), caller()));
}

void add_materials(py::class_<Builder>& builder) {
    builder.def("material", &add_material, "type"_a, py::kw_only(), "name"_a = "", "parameters"_a = py::none(),
                "material('diffuse', name='floor', reflectance=(0.5, 0.5, 0.5)): the name is the LPE label of its "
                "objects.\nReturns a Material. A mix refers to materials by name:  material('mix', materials=['floor', "
                "'wall'], amount=0.3). "
                "Subsurface's own\n"
                "parameter `name` is given as parameters={'name': 'Skin1'}. Errors: a duplicate name, parameters that "
                "the type\ndoes not have.");
    builder.def(
        "medium",
        [](Builder& self, const std::string& name, const std::string& type, const py::object& to_world,
           const py::object& parameters, const py::kwargs& keywords) {
            return take(self.open().add_medium(name, type,
                                               parameters_of(EntityKind::medium, type, parameters, keywords),
                                               transform_of(to_world, "to_world"), caller()));
        },
        "name"_a, "type"_a, py::kw_only(), "to_world"_a = py::none(), "parameters"_a = py::none(),
        "medium('fog', 'homogeneous', sigma_a=(0, 0, 0), sigma_s=(0.2, 0.2, 0.2)): coefficients per world unit. "
        "Returns "
        "a Medium,\n"
        "for `inside` and `outside` of shapes and `medium` of the camera; its name can be used instead, before or "
        "after this "
        "call.\n"
        "to_world, a (4, 4) matrix, places a grid's box. Errors: a duplicate name.");
}

void add_textures(py::class_<Builder>& builder) {
    py::options options;
    options.disable_function_signatures();  // there are two signatures, and the text shows the relevant one
    // These words are the method's arguments by position. As keywords they are pbrt's parameters of these names.
    builder.def("texture", &add_texture, py::arg(), py::arg(), py::arg(), py::kw_only(), "to_world"_a = py::none(),
                "parameters"_a = py::none());
    builder.def("texture", &add_texture, "name"_a, "value"_a, "type"_a, py::kw_only(), "to_world"_a = py::none(),
                "parameters"_a = py::none(),
                "texture(name, value, type, *, to_world=None, parameters=None, **parameters)\n\n"
                "texture('checks', 'spectrum', 'checkerboard'); used as reflectance=('texture', 'checks'). value is "
                "'float' or\n"
                "'spectrum'. to_world, a (4, 4) matrix, is the space of mappings other than uv. If all three are "
                "positional,\nkeywords belong to the texture:  texture('grey', 'float', 'constant', value=0.5).");
}

void add_lights(py::class_<Builder>& builder) {
    builder.def(
        "light",
        [](Builder& self, const std::string& type, const std::string& group, const py::object& to_world,
           const py::object& parameters, const py::kwargs& keywords) {
            take(self.open().add_light(type, parameters_of(EntityKind::light, type, parameters, keywords),
                                       transform_of(to_world, "to_world"), group, caller()));
        },
        "type"_a, py::kw_only(), "group"_a = "", "to_world"_a = py::none(), "parameters"_a = py::none(),
        "light('point', I=(10, 10, 10)), light('infinite', L=(1, 1, 1)); pbrt's `from`, a reserved word in Python, "
        "as\n"
        "parameters={'from': (0, 4, 0)}. group is the LPE light group; to_world a (4, 4) matrix.");
    builder.def(
        "area_light",
        [](Builder& self, const std::string& type, const std::string& group, const py::object& parameters,
           const py::kwargs& keywords) {
            return take(self.open().add_area_light(
                type, parameters_of(EntityKind::area_light, type, parameters, keywords), group, caller()));
        },
        "type"_a = "diffuse", py::kw_only(), "group"_a = "", "parameters"_a = py::none(),
        "area_light(L=(5, 5, 5)): radiance. Returns an AreaLight, which makes shapes emit.");
}

}  // namespace

void add_scene_builder(py::module_& module) {
    py::class_<transport::MaterialHandle>(module, "Material", "A material of one SceneBuilder.");
    py::class_<transport::AreaLightHandle>(module, "AreaLight", "An area light of one SceneBuilder.");
    py::class_<transport::MediumHandle>(module, "Medium", "A medium of one SceneBuilder.");
    py::class_<transport::ObjectHandle>(module, "Object",
                                        "A group of shapes in one SceneBuilder, placed by instances.");
    py::class_<Builder> builder(
        module, "SceneBuilder",
        "Builds a scene in code. Types, parameters and defaults are those of pbrt-v4's files and of plugins. Numbers "
        "get the\ntype that a parameter is known to have.  A list of str is several strings, three numbers are a "
        "colour where "
        "nothing\n"
        "else is known, ('point3', value) sets another type, ('texture', name) a texture. Every call takes parameters "
        "as\n"
        "keywords and, for words that are Python's or the method's own, as parameters={'from': ...}. Matrices are (4, "
        "4),\n"
        "points are columns; moved_to is the transform at the end of transform_times(). Errors name the line of "
        "the call.");
    builder.def(py::init(&make_builder), "name"_a = "scene", py::kw_only(), "folder"_a = py::none(),
                "missing_files"_a = "refused", "color_space"_a = "srgb",
                "name is the scene's name in messages. Relative file names are searched in folder, by default the "
                "current\none; missing_files='placeholders' replaces missing files by something magenta. rgb values "
                "are in\ncolor_space: srgb, dci-p3, rec2020 or aces2065-1, linear.");
    add_settings(builder);
    add_materials(builder);
    add_textures(builder);
    add_lights(builder);
    add_shapes(builder);
    builder.def(
        "finish",
        [](Builder& self) {
            SceneBuilder& scene = self.open();
            self.finished = true;
            auto description = take(scene.finish(caller()));
            return Scene{std::make_shared<const transport::SceneDescription>(std::move(description))};
        },
        "Returns the Scene and ends the builder, also after an error. Errors: an unknown name, a mesh that cannot be "
        "read.");
}

}  // namespace raylex::python
