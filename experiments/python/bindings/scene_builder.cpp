// Scenes from arrays: transport/scene/builder/scene_builder.h with Python's values as parameters.
#include <pybind11/stl.h>

#include <algorithm>

#include "experiments/python/bindings/arrays.h"
#include "experiments/python/bindings/scene.h"
#include "transport/scene/builder/scene_builder.h"

namespace raylex::python {

using namespace pybind11::literals;
using transport::SceneBuilder;

namespace {

/// Where in Python the call stands: "scene.py", line 12.
SourceLocation caller() {
    const py::object frame = py::module_::import("sys").attr("_getframe")();
    return {py::str(frame.attr("f_code").attr("co_filename")), frame.attr("f_lineno").cast<int>(), 0};
}

struct Builder {
    explicit Builder(const std::string& name) : scene(name) {}
    SceneBuilder scene;
    bool finished = false;
    SceneBuilder& open() {
        if (finished) fail("the builder's scene is finished; expected a new SceneBuilder");
        return scene;
    }
};

ParameterType type_of_numbers(const std::string& type, const std::string& name) {
    constexpr std::pair<const char*, ParameterType> known[] = {
        {"float", ParameterType::real},        {"integer", ParameterType::integer},
        {"rgb", ParameterType::rgb},           {"blackbody", ParameterType::blackbody},
        {"spectrum", ParameterType::spectrum}, {"point2", ParameterType::point2},
        {"vector2", ParameterType::vector2},   {"point3", ParameterType::point3},
        {"vector3", ParameterType::vector3},   {"normal", ParameterType::normal}};
    for (const auto& [word, value] : known)
        if (type == word) return value;
    fail("parameter '" + name + "' has the type '" + type +
         "'; expected float, integer, bool, string, rgb, blackbody, spectrum, point2, vector2, point3, vector3, normal "
         "or "
         "texture");
}

/// What the Python value says: bool, int, float, str, or three numbers for a colour. ("type", value) says another type.
Parameter parameter_of(const std::string& name, py::handle value) {
    Parameter parameter;
    parameter.name = name;
    parameter.location = caller();
    std::string type;
    if (py::isinstance<py::tuple>(value) && py::len(value) == 2 && py::isinstance<py::str>(value[py::int_(0)])) {
        type = value[py::int_(0)].cast<std::string>();
        value = py::reinterpret_borrow<py::tuple>(value)[1];
    }
    if (py::isinstance<py::bool_>(value) && (type.empty() || type == "bool")) {
        parameter.type = ParameterType::boolean;
        parameter.booleans = {static_cast<std::uint8_t>(value.cast<bool>())};
    } else if (py::isinstance<py::str>(value)) {
        parameter.strings = {value.cast<std::string>()};
        parameter.type = type == "texture"                  ? ParameterType::texture
                         : type == "spectrum"               ? ParameterType::spectrum
                         : type.empty() || type == "string" ? ParameterType::string
                                                            : type_of_numbers(type, name);
    } else {
        const Array<double> numbers = array_of<double>(value, "parameter '" + name + "'");
        parameter.numbers.assign(numbers.data(), numbers.data() + numbers.size());
        const bool whole = py::isinstance<py::int_>(value);
        const bool color = numbers.ndim() == 1 && numbers.size() == 3;
        parameter.type = !type.empty() ? type_of_numbers(type, name)
                         : color       ? ParameterType::rgb
                         : whole       ? ParameterType::integer
                                       : ParameterType::real;
    }
    return parameter;
}

transport::SceneParameters parameters_of(const py::dict& values) {
    ParameterSet set;
    set.location = caller();
    for (const auto& [name, value] : values) set.parameters.push_back(parameter_of(name.cast<std::string>(), value));
    return set;
}

/// Row-major (4, 4), points are columns; None is the identity.
transport::Transform transform_of(const py::object& object) {
    if (object.is_none()) return {};
    const Array<double> array = array_of<double>(object, "the transform");
    check_shape(array, 4, 4, "the transform");
    transport::Matrix4 matrix{};
    for (std::size_t i = 0; i < 16; ++i) matrix[i / 4][i % 4] = array.data()[i];
    const transport::Transform transform(matrix);
    if (!transform.invertible()) fail("the transform has no inverse; expected one that does not flatten space");
    return transform;
}

std::vector<transport::StoredVec3> triples(const py::object& object, const std::string& what) {
    const Array<float> array = array_of<float>(object, what);
    check_shape(array, static_cast<std::size_t>(array.ndim() > 0 ? array.shape(0) : 0), 3, what);
    std::vector<transport::StoredVec3> values(static_cast<std::size_t>(array.shape(0)));
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = {array.data()[3 * i], array.data()[3 * i + 1], array.data()[3 * i + 2]};
    return values;
}

std::vector<transport::StoredVec2> pairs(const py::object& object, const std::string& what) {
    const Array<float> array = array_of<float>(object, what);
    check_shape(array, static_cast<std::size_t>(array.ndim() > 0 ? array.shape(0) : 0), 2, what);
    std::vector<transport::StoredVec2> values(static_cast<std::size_t>(array.shape(0)));
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = {array.data()[2 * i], array.data()[2 * i + 1]};
    return values;
}

transport::MeshData mesh_of(const py::object& positions, const py::object& indices, const py::object& normals,
                            const py::object& uvs) {
    transport::MeshData mesh;
    mesh.positions = triples(positions, "positions");
    const Array<std::int64_t> faces = array_of<std::int64_t>(indices, "indices");
    mesh.patches = faces.ndim() == 2 && faces.shape(1) == 4;
    if (!mesh.patches)
        check_shape(faces, static_cast<std::size_t>(faces.ndim() > 0 ? faces.shape(0) : 0), 3, "indices");
    for (py::ssize_t i = 0; i < faces.size(); ++i) {
        const std::int64_t index = faces.data()[i];
        if (index < 0 || index >= static_cast<std::int64_t>(mesh.positions.size()))
            fail("indices has " + std::to_string(index) + ", and there are " + std::to_string(mesh.positions.size()) +
                 " positions; expected 0 to " + std::to_string(mesh.positions.size() - 1));
        mesh.indices.push_back(static_cast<std::uint32_t>(index));
    }
    if (!normals.is_none()) mesh.normals = triples(normals, "normals");
    if (!uvs.is_none()) mesh.uvs = pairs(uvs, "uvs");
    return mesh;
}

transport::ShapePlacement placement_of(SceneBuilder& scene, const py::object& material, const py::object& area_light,
                                       const py::object& to_world, const std::string& label, bool reverse) {
    transport::ShapePlacement placement;
    placement.to_world = transform_of(to_world);
    if (py::isinstance<py::str>(material))
        placement.material = scene.material_named(material.cast<std::string>(), caller());
    else if (!material.is_none()) placement.material = material.cast<transport::MaterialHandle>();
    if (!area_light.is_none()) placement.area_light = area_light.cast<transport::AreaLightHandle>();
    placement.label = label;
    placement.reverse_orientation = reverse;
    return placement;
}

void add_settings(py::class_<Builder>& builder) {
    using Setter = Status (SceneBuilder::*)(const std::string&, transport::SceneParameters, const SourceLocation&);
    const auto add = [&](const char* name, Setter setter, const char* help) {
        builder.def(
            name,
            [setter](Builder& self, const std::string& type, const py::kwargs& parameters) {
                take((self.open().*setter)(type, parameters_of(parameters), caller()));
            },
            "type"_a, help);
    };
    add("film", &SceneBuilder::set_film, "film('rgb', xresolution=640, yresolution=480)");
    add("filter", &SceneBuilder::set_filter, "filter('gaussian', xradius=1.5)");
    add("sampler", &SceneBuilder::set_sampler, "sampler('independent', pixelsamples=16)");
    add("integrator", &SceneBuilder::set_integrator, "integrator('path', maxdepth=5)");
    builder.def(
        "camera",
        [](Builder& self, const std::string& type, const std::array<double, 3>& eye, const std::array<double, 3>& look,
           const std::array<double, 3>& up, const py::kwargs& parameters) {
            const transport::Transform view = transport::Transform::look_at(eye, look, up);
            if (!view.invertible())
                fail("'up' lies along the direction of view, or eye and look are one; expected another direction");
            take(self.open().set_camera(type, parameters_of(parameters), view, {}, caller()));
        },
        "type"_a, py::kw_only(), "eye"_a, "look"_a, "up"_a = std::array<double, 3>{0, 1, 0},
        "camera('perspective', eye=(0, 0, 4), look=(0, 0, 0), fov=40): world units, fov in degrees of the shorter "
        "side.");
}

void add_materials_and_lights(py::class_<Builder>& builder) {
    builder.def(
        "material",
        [](Builder& self, const std::string& type, const std::string& name, const py::kwargs& parameters) {
            SceneBuilder& scene = self.open();
            return take(name.empty() ? scene.add_material(type, parameters_of(parameters), caller())
                                     : scene.add_named_material(name, type, parameters_of(parameters), caller()));
        },
        "type"_a, py::kw_only(), "name"_a = "",
        "material('diffuse', name='floor', reflectance=(0.5, 0.5, 0.5)): the name is the LPE label of what it is on.");
    builder.def(
        "texture",
        [](Builder& self, const std::string& name, const std::string& value, const std::string& type,
           const py::kwargs& parameters) {
            if (value != "float" && value != "spectrum")
                fail("a texture is 'float' or 'spectrum', not '" + value + "'");
            const auto kind = value == "float" ? transport::TextureValue::real : transport::TextureValue::spectrum;
            take(self.open().add_texture(name, kind, type, parameters_of(parameters), {}, caller()));
        },
        "name"_a, "value"_a, "type"_a,
        "texture('checks', 'spectrum', 'checkerboard'); used as reflectance=('texture', 'checks').");
    builder.def(
        "light",
        [](Builder& self, const std::string& type, const std::string& group, const py::object& to_world,
           const py::kwargs& parameters) {
            take(self.open().add_light(type, parameters_of(parameters), transform_of(to_world), group, caller()));
        },
        "type"_a, py::kw_only(), "group"_a = "", "to_world"_a = py::none(),
        "light('point', I=(10, 10, 10)), light('infinite', L=(1, 1, 1)); names in the `from` of lights: **{'from': "
        "...}.");
    builder.def(
        "area_light",
        [](Builder& self, const std::string& type, const std::string& group, const py::kwargs& parameters) {
            return take(self.open().add_area_light(type, parameters_of(parameters), group, caller()));
        },
        "type"_a = "diffuse", py::kw_only(), "group"_a = "",
        "area_light(L=(5, 5, 5)): radiance; given to shapes, it makes them shine.");
}

void add_shapes(py::class_<Builder>& builder) {
    builder.def(
        "shape",
        [](Builder& self, const std::string& type, const py::object& material, const py::object& area_light,
           const py::object& to_world, const std::string& label, bool reverse, const py::kwargs& parameters) {
            SceneBuilder& scene = self.open();
            take(scene.add_shape(type, parameters_of(parameters),
                                 placement_of(scene, material, area_light, to_world, label, reverse), caller()));
        },
        "type"_a, py::kw_only(), "material"_a = py::none(), "area_light"_a = py::none(), "to_world"_a = py::none(),
        "label"_a = "", "reverse_orientation"_a = false, "shape('sphere', radius=1, material=floor)");
    builder.def(
        "mesh",
        [](Builder& self, const py::object& positions, const py::object& indices, const py::object& normals,
           const py::object& uvs, const py::object& material, const py::object& area_light, const py::object& to_world,
           const std::string& label, bool reverse) {
            SceneBuilder& scene = self.open();
            take(scene.add_mesh(mesh_of(positions, indices, normals, uvs),
                                placement_of(scene, material, area_light, to_world, label, reverse), caller()));
        },
        "positions"_a, "indices"_a, py::kw_only(), "normals"_a = py::none(), "uvs"_a = py::none(),
        "material"_a = py::none(), "area_light"_a = py::none(), "to_world"_a = py::none(), "label"_a = "",
        "reverse_orientation"_a = false,
        "A mesh: positions (V, 3) float32, indices (F, 3) triangles or (F, 4) bilinear patches p00 p10 p01 p11,\n"
        "normals (V, 3), uvs (V, 2).");
}

}  // namespace

void add_scene_builder(py::module_& module) {
    py::class_<transport::MaterialHandle>(module, "Material", "A material of one SceneBuilder.");
    py::class_<transport::AreaLightHandle>(module, "AreaLight", "An area light of one SceneBuilder.");
    py::class_<Builder> builder(module, "SceneBuilder",
                                "Makes a scene in code. Types, parameters and defaults are those of pbrt-v4's files "
                                "and of plugins. A Python bool,\n"
                                "int, float or str is that type, three numbers are a colour; ('point3', value) says "
                                "another type. to_world is a\n"
                                "(4, 4) matrix, points are columns.");
    builder.def(py::init<const std::string&>(), "name"_a = "scene");
    add_settings(builder);
    add_materials_and_lights(builder);
    add_shapes(builder);
    builder.def(
        "finish",
        [](Builder& self) {
            auto description = take(self.open().finish());
            self.finished = true;
            return Scene{std::make_shared<const transport::SceneDescription>(std::move(description))};
        },
        "The Scene; the builder is spent. Errors: a name that nothing has.");
}

}  // namespace raylex::python
