// Shapes, objects and instances of the Python SceneBuilder.
#include <pybind11/stl.h>

#include "experiments/python/bindings/scenes/scene_builder.h"

namespace raylex::python {

using namespace pybind11::literals;
using transport::EntityKind;
using transport::SceneBuilder;

namespace {

/// The arguments that all methods for shapes share.
struct Placing {
    const py::object &material, &area_light, &to_world, &moved_to, &inside, &outside, &object;
    const std::string& label;
    bool reverse;
};

transport::ObjectHandle object_of(SceneBuilder& scene, const py::object& object) {
    if (py::isinstance<py::str>(object)) return scene.object_named(object.cast<std::string>(), caller());
    if (py::isinstance<transport::ObjectHandle>(object)) return object.cast<transport::ObjectHandle>();
    fail_here("object is " + shown(object) + "; expected an Object from SceneBuilder.object(), or its name");
}

transport::ShapePlacement placement_of(SceneBuilder& scene, const Placing& given) {
    transport::ShapePlacement placement;
    placement.to_world = transform_of(given.to_world, "to_world");
    placement.moved_to = transform_or_none(given.moved_to, "moved_to");
    if (py::isinstance<py::str>(given.material))
        placement.material = scene.material_named(given.material.cast<std::string>(), caller());
    else if (py::isinstance<transport::MaterialHandle>(given.material))
        placement.material = given.material.cast<transport::MaterialHandle>();
    else if (!given.material.is_none())
        fail_here("material is " + shown(given.material) +
                  "; expected a Material from SceneBuilder.material(), its name, or None");
    if (py::isinstance<transport::AreaLightHandle>(given.area_light))
        placement.area_light = given.area_light.cast<transport::AreaLightHandle>();
    else if (!given.area_light.is_none())
        fail_here("area_light is " + shown(given.area_light) +
                  "; expected an AreaLight from SceneBuilder.area_light(), or None; area lights have no names");
    placement.inside = medium_of(scene, given.inside, "inside");
    placement.outside = medium_of(scene, given.outside, "outside");
    if (!given.object.is_none()) placement.object = object_of(scene, given.object);
    placement.label = given.label;
    placement.reverse_orientation = given.reverse;
    return placement;
}

void add_shape(Builder& self, const std::string& type, const py::object& material, const py::object& area_light,
               const py::object& to_world, const py::object& moved_to, const py::object& inside,
               const py::object& outside, const py::object& object, const std::string& label, bool reverse,
               const py::object& parameters, const py::kwargs& keywords) {
    SceneBuilder& scene = self.open();
    const transport::ShapePlacement placement =
        placement_of(scene, {material, area_light, to_world, moved_to, inside, outside, object, label, reverse});
    take(scene.add_shape(type, parameters_of(EntityKind::shape, type, parameters, keywords), placement, caller()));
}

void add_mesh(Builder& self, const py::object& positions, const py::object& indices, const py::object& normals,
              const py::object& uvs, const py::object& material, const py::object& area_light,
              const py::object& to_world, const py::object& moved_to, const py::object& inside,
              const py::object& outside, const py::object& object, const std::string& label, bool reverse) {
    SceneBuilder& scene = self.open();
    transport::MeshData mesh;
    mesh.positions = triples(positions, "positions");
    const Array<double> faces = indices_of(indices, "indices", mesh.positions.size(), "positions");
    mesh.patches = faces.ndim() == 2 && faces.shape(1) == 4;
    if (!mesh.patches)
        check_shape_here(faces, static_cast<std::size_t>(faces.ndim() > 0 ? faces.shape(0) : 0), 3, "indices");
    for (py::ssize_t i = 0; i < faces.size(); ++i) mesh.indices.push_back(static_cast<std::uint32_t>(faces.data()[i]));
    if (!normals.is_none()) mesh.normals = triples(normals, "normals");
    if (!uvs.is_none()) mesh.uvs = pairs(uvs, "uvs");
    take(scene.add_mesh(
        mesh, placement_of(scene, {material, area_light, to_world, moved_to, inside, outside, object, label, reverse}),
        caller()));
}

void add_curves(Builder& self, const py::object& points, const py::object& first_points, const py::object& widths,
                const std::string& type, const py::object& normals, const py::object& material,
                const py::object& area_light, const py::object& to_world, const py::object& moved_to,
                const py::object& inside, const py::object& outside, const py::object& object, const std::string& label,
                bool reverse) {
    SceneBuilder& scene = self.open();
    transport::CurveData curves;
    if (type == "cylinder") curves.type = transport::CurveType::cylinder;
    else if (type == "ribbon") curves.type = transport::CurveType::ribbon;
    else if (type != "flat") fail_here("curves of type '" + type + "'; expected flat, cylinder or ribbon");
    curves.points = triples(points, "points");
    const Array<double> firsts = indices_of(first_points, "first_points", curves.points.size(), "points");
    check_shape_here(firsts, static_cast<std::size_t>(firsts.size()), 0, "first_points");
    for (py::ssize_t i = 0; i < firsts.size(); ++i)
        curves.first_points.push_back(static_cast<std::uint32_t>(firsts.data()[i]));
    curves.widths = pairs(widths, "widths");
    if (!normals.is_none()) curves.normals = triples(normals, "normals");
    take(scene.add_curves(
        curves,
        placement_of(scene, {material, area_light, to_world, moved_to, inside, outside, object, label, reverse}),
        caller()));
}

void add_instance(Builder& self, const py::object& object, const py::object& to_world, const py::object& moved_to) {
    SceneBuilder& scene = self.open();
    const transport::ObjectHandle placed = object_of(scene, object);
    const transport::Transform first = transform_of(to_world, "to_world");
    if (const auto last = transform_or_none(moved_to, "moved_to"))
        take(scene.add_moving_instance(placed, first, *last, caller()));
    else take(scene.add_instance(placed, first, caller()));
}

/// Defines a method with the arguments of Placing as keywords.
template <typename Function, typename... Arguments>
void def_shape(py::class_<Builder>& builder, const char* name, const Function& function,
               const Arguments&... arguments) {
    builder.def(name, function, arguments..., "material"_a = py::none(), "area_light"_a = py::none(),
                "to_world"_a = py::none(), "moved_to"_a = py::none(), "inside"_a = py::none(), "outside"_a = py::none(),
                "object"_a = py::none(), "label"_a = "", "reverse_orientation"_a = false);
}

void add_any_shape(py::class_<Builder>& builder) {
    py::options options;
    options.disable_function_signatures();  // there are two signatures, and the text shows the relevant one
    const auto def_type = [&](const py::arg& type, const char* help) {
        builder.def("shape", &add_shape, type, py::kw_only(), "material"_a = py::none(), "area_light"_a = py::none(),
                    "to_world"_a = py::none(), "moved_to"_a = py::none(), "inside"_a = py::none(),
                    "outside"_a = py::none(), "object"_a = py::none(), "label"_a = "", "reverse_orientation"_a = false,
                    "parameters"_a = py::none(), help);
    };
    // By position `type` is the shape's; as a keyword it is a curve's parameter of that name.
    def_type(py::arg(), "");
    def_type("type"_a,
             "shape(type, *, material=None, area_light=None, to_world=None, moved_to=None, inside=None, outside=None,\n"
             "      object=None, label='', reverse_orientation=False, parameters=None, **parameters)\n\n"
             "shape('sphere', radius=1, material=floor). material: a Material or its name, which may be defined later; "
             "by default\ngrey.  area_light: an AreaLight. to_world: a (4, 4) matrix; moved_to another one, at the end "
             "of a motion; moving shapes\ncannot emit.  inside, outside: the media on its two sides, each a Medium or "
             "its name; None is "
             "vacuum. object: an\n"
             "Object or its name to which the shape belongs; to_world then maps to the object's space.  label: LPE "
             "label, by "
             "default the\n"
             "material's name. shape('curve', type='ribbon'): a curve's type is its keyword.");
}

}  // namespace

void add_shapes(py::class_<Builder>& builder) {
    add_any_shape(builder);
    def_shape(
        builder, "mesh", &add_mesh, "positions"_a, "indices"_a, py::kw_only(), "normals"_a = py::none(),
        "uvs"_a = py::none(),
        py::doc(
            "A mesh: positions (V, 3) float32 in the space of to_world, indices (F, 3) triangles or (F, 4) "
            "bilinear patches\n"
            "p00 p10 p01 p11, normals (V, 3), uvs (V, 2); other arguments as for shape(). Normals that are 0 or not "
            "finite are\ncomputed from faces, and such uvs become 0, with a warning. Errors: positions that are not "
            "finite, indices that\nare not integers or out of range."));
    def_shape(
        builder, "curves", &add_curves, "points"_a, "first_points"_a, "widths"_a, py::kw_only(), "type"_a = "flat",
        "normals"_a = py::none(),
        py::doc("Curves of cubic Bezier segments: points (P, 3), 3 n + 1 per curve; first_points (C,), where each "
                "curve's begin;\n"
                "widths (C, 2), at its start and end, in the space of to_world; type flat, cylinder or ribbon, "
                "which has normals,\nn + 1 per curve. Other arguments as for shape()."));
    builder.def(
        "object", [](Builder& self, const std::string& name) { return take(self.open().add_object(name, caller())); },
        "name"_a,
        "Returns an Object. Shapes with this `object` appear only where instance() places it. Area lights do not emit "
        "in\nit (pbrt's rule). Errors: a duplicate name.");
    builder.def("instance", &add_instance, "object"_a, py::kw_only(), "to_world"_a = py::none(),
                "moved_to"_a = py::none(),
                "Places an Object (or its name) by a (4, 4) matrix from its space to the world; moved_to is the matrix "
                "at the end of\na motion.  Errors: a matrix without an inverse, an Object of another builder.");
}

}  // namespace raylex::python
