// Shapes, objects and instances of a SceneBuilder. Mesh files are only recorded here: read_meshes() reads all of them
// at the end.
#include <algorithm>
#include <cmath>

#include "transport/geometry/shapes/curve.h"
#include "transport/geometry/shapes/placed_mesh.h"
#include "transport/import/builder/scene_builder.h"
#include "transport/import/builder/settled_transform.h"
#include "transport/import/shapes/curve_shapes.h"
#include "transport/import/shapes/shapes.h"
#include "transport/math/animated_transform.h"

namespace raylex::transport {

namespace {

/// Sets texture coordinates that are not finite to 0, as for mesh files.
void set_broken_uvs(SceneShape& mesh, std::vector<Error>& warnings) {
    std::size_t broken = 0;
    for (StoredVec2& uv : mesh.uvs) {
        if (std::isfinite(uv.x) && std::isfinite(uv.y)) continue;
        uv = {0, 0};
        ++broken;
    }
    if (broken > 0)
        warnings.push_back(error_at(mesh.location, std::to_string(broken) + " of the texture coordinates of the mesh "
                                                                            "are not finite and were set to 0"));
}

}  // namespace

Status SceneBuilder::add_shape(const std::string& type, SceneParameters parameters, const ShapePlacement& placement,
                               const SourceLocation& where) {
    if (Status s = check_placement(placement, where); !s) return s;
    if (placement.moved_to) {
        const auto still = as_moving_object(placement, where);
        if (!still) return still.error();
        return add_shape(type, std::move(parameters), *still, where);
    }
    const Result<ParameterSet> set = checked(type, EntityKind::shape, std::move(parameters), where);
    if (!set) return set.error();
    if (!placement.to_world.invertible()) return add_flattened(type, *set, placement, where);
    const Result<Transform> transform = settled(placement.to_world, where);
    if (!transform) return transform.error();
    const Parameter* file = set->find("filename");
    const bool mesh = type == "plymesh" && file != nullptr && file->type == ParameterType::string &&
                      file->strings.size() == 1 && !file->strings.front().empty();
    if (mesh) {
        const Result<std::string> found = search_.find(file->strings.front(), file->location);
        if (!found && missing_ == MissingFiles::placeholders)
            return place_missing_mesh(file->strings.front(), placement, where);
        if (!found) return found.error();
        const auto target = shapes_of(placement, where);
        if (!target) return target.error();
        meshes_.push_back({std::move(*set), *transform, placement, search_, (*target)->size(), scene_.warnings.size()});
        return success();
    }
    Result<std::vector<SceneShape>> shapes =
        make_shapes(type, *set, {*transform, placement.reverse_orientation, search_}, scene_.warnings);
    if (!shapes) return shapes.error();
    return place(std::move(*shapes), placement, where);
}

/// Adds a shape whose transformation has no inverse. Meshes become flat, as in pbrt, except that normals are dropped,
/// since pbrt defines none. Other shapes have no area.
Status SceneBuilder::add_flattened(const std::string& type, const ParameterSet& set, const ShapePlacement& placement,
                                   const SourceLocation& where) {
    Result<std::vector<SceneShape>> shapes =
        make_shapes(type, set, {Transform(), placement.reverse_orientation, search_}, scene_.warnings);
    if (!shapes) return shapes.error();
    for (SceneShape& shape : *shapes) {
        const bool mesh = shape.kind == ShapeKind::triangle_mesh || shape.kind == ShapeKind::bilinear_mesh;
        shape.normals.clear();
        shape.displacement_texture.clear();
        for (StoredVec3& p : shape.positions) {
            const auto [x, y, z] = placement.to_world.point_in_double({double(p.x), double(p.y), double(p.z)});
            p = {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
        }
        if (mesh) drop_faces_without_area(shape.kind, shape.positions, shape.indices);
        else shape.indices.clear();
    }
    std::erase_if(*shapes, [](const SceneShape& shape) { return shape.indices.empty(); });
    warn(error_at(where, std::string("its transformation cannot be inverted: ") +
                             (shapes->empty() ? "the shape has no area and is left out"
                                              : "the shape is flat and uses face normals")));
    ShapePlacement flat = placement;
    flat.to_world = Transform();
    return place(std::move(*shapes), flat, where);
}

Status SceneBuilder::add_mesh(const MeshData& mesh, const ShapePlacement& placement, const SourceLocation& where) {
    if (Status s = check_placement(placement, where); !s) return s;
    if (placement.moved_to) {
        const auto still = as_moving_object(placement, where);
        if (!still) return still.error();
        return add_mesh(mesh, *still, where);
    }
    const Result<Transform> transform = settled(placement.to_world, where);
    if (!transform) return transform.error();
    const std::size_t vertices = mesh.positions.size(), group = mesh.patches ? 4 : 3;
    const auto fits = [&](std::size_t count) { return count == 0 || count == vertices; };
    if (!fits(mesh.normals.size()) || !fits(mesh.uvs.size()))
        return error_at(where, "mesh of " + std::to_string(vertices) + " vertices has " +
                                   std::to_string(mesh.normals.size()) + " normals and " +
                                   std::to_string(mesh.uvs.size()) + " uvs; expected as many as vertices, or none");
    if (mesh.indices.size() % group != 0)
        return error_at(where, "mesh has " + std::to_string(mesh.indices.size()) + " indices; expected a multiple of " +
                                   std::to_string(group));
    for (const std::uint32_t index : mesh.indices)
        if (index >= vertices)
            return error_at(where, "mesh index " + std::to_string(index) + " is out of range; there are " +
                                       std::to_string(vertices) + " vertices");
    for (std::size_t i = 0; i < vertices; ++i)
        if (!is_finite(mesh.positions[i]))
            return error_at(where, "position " + std::to_string(i) + " of the mesh is not finite");
    SceneShape shape;
    shape.kind = mesh.patches ? ShapeKind::bilinear_mesh : ShapeKind::triangle_mesh;
    shape.location = where;
    shape.positions = mesh.positions;
    shape.normals = mesh.normals;
    shape.uvs = mesh.uvs;
    shape.indices = mesh.indices;
    set_broken_uvs(shape, scene_.warnings);
    Result<std::vector<SceneShape>> shapes = finish_mesh(
        std::move(shape), "the mesh", {*transform, placement.reverse_orientation, search_}, scene_.warnings);
    if (!shapes) return shapes.error();
    return place(std::move(*shapes), placement, where);
}

Status SceneBuilder::add_curves(const CurveData& curves, const ShapePlacement& placement, const SourceLocation& where) {
    if (Status s = check_placement(placement, where); !s) return s;
    if (placement.moved_to) {
        const auto still = as_moving_object(placement, where);
        if (!still) return still.error();
        return add_curves(curves, *still, where);
    }
    const Result<Transform> transform = settled(placement.to_world, where);
    if (!transform) return transform.error();
    SceneShape shape;
    shape.kind = ShapeKind::curves;
    shape.location = where;
    shape.curve_type = curves.type;
    shape.positions = curves.points;
    shape.indices = curves.first_points;
    shape.curve_widths = curves.widths;
    shape.normals = curves.normals;
    shape.object_to_world = *transform;
    shape.flip_normal = placement.reverse_orientation != transform->swaps_handedness();
    if (Status status = check_curves(shape); !status) return status.error();
    return place({std::move(shape)}, placement, where);
}

/// Turns a moving shape into an object with one instance; returns the placement of the shape in that object.
Result<ShapePlacement> SceneBuilder::as_moving_object(const ShapePlacement& placement, const SourceLocation& where) {
    const bool in_object = placement.object.reference >= 0;
    if (placement.area_light.reference >= 0 && !in_object)
        return error_at(where, "an area light moves; expected lights that stand still",
                        "the camera and everything else can move past it");
    std::string name;
    do name = "moving shape " + std::to_string(++moving_shapes_);
    while (named_objects_.count(name) != 0);
    const Result<ObjectHandle> object = add_object({name}, where);
    if (!object) return object.error();
    if (in_object)
        moving_parts_.push_back({placement.object.reference, *object, placement.to_world, *placement.moved_to, where});
    else if (Status s = add_moving_instance(*object, placement.to_world, *placement.moved_to, where); !s)
        return s.error();
    ShapePlacement still = placement;
    still.to_world = Transform();
    still.moved_to.reset();
    still.object = *object;
    return still;
}

/// Adds, for every instance of an object with moving parts, an instance of each part.
Status SceneBuilder::place_moving_parts() {
    const std::size_t instances = scene_.instances.size();
    for (std::size_t i = 0; i < instances && !moving_parts_.empty(); ++i)
        for (const MovingPart& part : moving_parts_) {
            const SceneInstance& whole = scene_.instances[i];
            if (part.object != whole.object) continue;
            const Transform first = whole.to_world,
                            last = whole.motion < 0 ? first : scene_.moved_to[static_cast<std::size_t>(whole.motion)];
            if (Status s = add_moving_instance(part.part, first * part.first, last * part.last, part.location); !s)
                return s;
        }
    return success();
}

Result<std::vector<SceneShape>*> SceneBuilder::shapes_of(const ShapePlacement& placement, const SourceLocation& where) {
    if (placement.object.reference < 0) return &scene_.shapes;
    const Reference& object = object_references_[static_cast<std::size_t>(placement.object.reference)];
    const auto found = named_objects_.find(object.name);
    if (found == named_objects_.end())
        return error_at(where, "the object '" + object.name + "' gets a shape before it is added");
    return &scene_.objects[static_cast<std::size_t>(found->second)].shapes;
}

Status SceneBuilder::place(std::vector<SceneShape> shapes, const ShapePlacement& placement,
                           const SourceLocation& where) {
    if (placement.object.reference >= 0 && placement.area_light.reference >= 0)
        warn(error_at(where, "area lights do not emit from object instances (pbrt's rule); this shape is dark"));
    const auto target = shapes_of(placement, where);
    if (!target) return target.error();
    append(**target, std::move(shapes), placement);
    return success();
}

void SceneBuilder::append(std::vector<SceneShape>& target, std::vector<SceneShape> shapes,
                          const ShapePlacement& placement) {
    const auto named = [this](const SceneShape& of) -> const Reference& {
        return material_references_[static_cast<std::size_t>(of.material)];
    };
    for (SceneShape& shape : shapes) {
        shape.material = placement.material.reference;  // resolved in finish()
        shape.inside_medium = placement.inside.reference;
        shape.outside_medium = placement.outside.reference;
        shape.area_light = placement.object.reference >= 0 ? -1 : placement.area_light.reference;
        shape.label = placement.label;
        const auto same_material = [&](const SceneShape& other) {
            return named(other).index == named(shape).index && named(other).name == named(shape).name;
        };
        if (!target.empty() && join_curves(target.back(), shape, same_material(target.back()))) continue;
        target.push_back(std::move(shape));
    }
}

Result<ObjectHandle> SceneBuilder::add_object(const SceneName& name, const SourceLocation& where) {
    if (Status s = check_open(where); !s) return s.error();
    if (!named_objects_.emplace(name.text, static_cast<int>(scene_.objects.size())).second)
        return error_at(name.place(where), "object '" + name.text + "' is defined twice");
    scene_.objects.push_back({name.text, {}});
    return object_named(name, where);
}

ObjectHandle SceneBuilder::object_named(const SceneName& name, const SourceLocation& where) {
    // A million instances of a few objects share a few references.
    const auto [found, fresh] = object_reference_of_.emplace(name.text, static_cast<int>(object_references_.size()));
    if (fresh) object_references_.push_back({-1, name.text, name.place(where)});
    return handle<ObjectHandle>(found->second);
}

Status SceneBuilder::add_instance(ObjectHandle object, const Transform& to_world, const SourceLocation& where) {
    if (Status s = check_instance(object, to_world, where); !s) return s;
    if (!to_world.invertible()) {
        warn(error_at(where, "its transformation cannot be inverted: the instance has no extent and is left out"));
        return success();
    }
    const Result<Transform> transform = settled(to_world, where);
    if (!transform) return transform.error();
    if (!is_affine(transform->matrix()))
        return error_at(where, "an instance's transformation must be affine: the last row of its matrix 0 0 0 1",
                        "transforms of shapes need not be affine: place the shapes without an instance");
    SceneInstance instance;
    instance.object = object.reference;  // resolved in finish()
    instance.to_world = *transform;
    instance.location = where;
    scene_.instances.push_back(std::move(instance));
    return success();
}

Status SceneBuilder::add_moving_instance(ObjectHandle object, const Transform& to_world, const Transform& moved_to,
                                         const SourceLocation& where) {
    if (Status s = check_instance(object, to_world, where); !s) return s;
    const Result<Transform> last = settled(moved_to, where);
    if (!last) return last.error();
    if (!to_world.invertible()) return add_instance(object, to_world, where);
    if (Status s = add_instance(object, to_world, where); !s) return s;
    if (const auto way = AnimatedTransform::between(to_world, *last, where); !way) return way.error();
    scene_.instances.back().motion = static_cast<std::int32_t>(scene_.moved_to.size());
    scene_.moved_to.push_back(*last);
    return success();
}

}  // namespace raylex::transport
