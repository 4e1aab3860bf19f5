#include "transport/scene/scene_builder.h"

#include <algorithm>
#include <iterator>

#include "transport/cameras/aperture.h"
#include "transport/color/spectral_data.h"
#include "transport/geometry/curve.h"
#include "transport/import/curve_shapes.h"
#include "transport/import/shapes.h"
#include "transport/math/animated_transform.h"

namespace raylex::transport {

namespace {

bool names_a_file(const Parameter& parameter) {
    return parameter.type == ParameterType::string &&
           (parameter.name == "filename" || parameter.name == "normalmap" || parameter.name == "lensfile" ||
            (parameter.name == "aperture" && !parameter.strings.empty() &&
             !Aperture::is_built_in(parameter.strings.front())));
}

/// pbrt's three spellings of "nothing but a boundary".
std::string material_type(const std::string& written) {
    return written.empty() || written == "none" ? "interface" : written;
}

const SourceLocation& place_of(const SceneName& name, const SourceLocation& where) {
    return name.where.file.empty() ? where : name.where;
}

Error defined_twice(const std::string& what, const SceneName& name, const SourceLocation& where,
                    const SourceLocation& first) {
    return error_at(place_of(name, where), what + " '" + name.text + "' is defined twice; the first is at " +
                                               first.file + ":" + std::to_string(first.line));
}

/// As its matrix says. The inverse follows from it and from nothing else, so that a scene written to a file and read
/// again has the same bits.
Result<Transform> settled(const Transform& transform, const SourceLocation& where) {
    if (transform.is_identity()) return Transform();
    Transform result(transform.matrix());
    if (!transform.invertible() || !result.invertible())
        return error_at(where, "its transformation cannot be inverted");
    return result;
}

bool is_affine(const Matrix4& m) {
    return m[3][0] == 0 && m[3][1] == 0 && m[3][2] == 0 && m[3][3] == 1;
}

/// The same for cameras, whose place is exact however far away it is: a linear map after a translation.
Result<Transform> settled_camera(const Transform& world_to_camera, const SourceLocation& where) {
    const Matrix4 camera_to_world = world_to_camera.inverse().matrix();
    if (!world_to_camera.invertible() || !is_affine(world_to_camera.matrix()) || !is_affine(camera_to_world))
        return settled(world_to_camera, where);
    Matrix4 linear = world_to_camera.matrix();
    for (std::size_t i = 0; i < 3; ++i) linear[i][3] = 0;
    const Result<Transform> turned = settled(Transform(linear), where);
    if (!turned) return turned.error();
    return *turned * Transform::translate(-camera_to_world[0][3], -camera_to_world[1][3], -camera_to_world[2][3]);
}

}  // namespace

SceneBuilder::SceneBuilder(std::string file, SearchPath search) : search_(std::move(search)) {
    scene_.file = std::move(file);
    SceneEntity fallback;
    fallback.type = "diffuse";
    fallback.parameters.parameters.push_back(typed::rgb("reflectance", {0.5, 0.5, 0.5}));
    fallback.location = fallback.parameters.location = {scene_.file, 0, 0};
    scene_.materials.push_back(std::move(fallback));
    material_references_.push_back({0, {}, {}});
}

/// All parameters, known ones alone, the own ones first.
Result<ParameterSet> SceneBuilder::checked(const std::string& type, EntityKind kind, SceneParameters parameters,
                                           const SourceLocation& where) {
    ParameterSet set = std::move(parameters.own);
    if (set.location.file.empty()) set.location = where;
    for (Parameter& parameter : set.parameters)
        if (parameter.location.file.empty()) parameter.location = where;
    const std::size_t own = set.parameters.size();
    for (Parameter& fallback : parameters.fallbacks)
        if (std::none_of(set.parameters.begin(), set.parameters.end(),
                         [&](const Parameter& p) { return p.name == fallback.name; }))
            set.parameters.push_back(std::move(fallback));
    if (Status s = parameters_.check(kind, type, set, own, scene_.warnings); !s) return s.error();
    return set;
}

Result<SceneEntity> SceneBuilder::make_entity(const std::string& type, EntityKind kind, SceneParameters parameters,
                                              const SourceLocation& where, bool float_texture) {
    SceneEntity entity;
    entity.type = type;
    entity.location = where;
    Result<ParameterSet> set = checked(type, kind, std::move(parameters), where);
    if (!set) return set.error();
    entity.parameters = std::move(*set);
    if (Status status = resolve_entity(entity, float_texture); !status) return status.error();
    return entity;
}

Status SceneBuilder::resolve_files(ParameterSet& set) const {
    for (Parameter& parameter : set.parameters) {
        const bool spectrum = parameter.type == ParameterType::spectrum;
        if (!spectrum && !names_a_file(parameter)) continue;
        for (std::string& name : parameter.strings) {
            VisibleSpectrum unused{};
            if (spectrum && find_named_spectrum(name, unused)) continue;
            Result<std::string> path = search_.find(name, parameter.location);
            if (!path) {
                Error error = path.error();
                if (!spectrum) return error;
                error.message = "'" + name + "' is neither a named spectrum nor a file";
                const std::string near = nearest_name(name, named_spectra());
                std::string known;
                for (const std::string& each : named_spectra()) known += " " + each;
                error.hint +=
                    (near.empty() ? "; known spectra:" : "; did you mean '" + near + "'? Known spectra:") + known;
                return error;
            }
            name = std::move(*path);
        }
    }
    return success();
}

Status SceneBuilder::settings(SceneEntity& target, EntityKind kind, const std::string& type, SceneParameters parameters,
                              const SourceLocation& where) {
    SceneEntity entity;
    entity.type = type;
    entity.location = where;
    Result<ParameterSet> set = checked(type, kind, std::move(parameters), where);
    if (!set) return set.error();
    entity.parameters = std::move(*set);
    target = std::move(entity);
    return success();
}

Status SceneBuilder::set_film(const std::string& type, SceneParameters parameters, const SourceLocation& where) {
    return settings(scene_.film, EntityKind::film, type, std::move(parameters), where);
}

Status SceneBuilder::set_filter(const std::string& type, SceneParameters parameters, const SourceLocation& where) {
    return settings(scene_.filter, EntityKind::pixel_filter, type, std::move(parameters), where);
}

Status SceneBuilder::set_sampler(const std::string& type, SceneParameters parameters, const SourceLocation& where) {
    return settings(scene_.sampler, EntityKind::sampler, type, std::move(parameters), where);
}

Status SceneBuilder::set_integrator(const std::string& type, SceneParameters parameters, const SourceLocation& where) {
    return settings(scene_.integrator, EntityKind::integrator, type, std::move(parameters), where);
}

Status SceneBuilder::set_camera(const std::string& type, SceneParameters parameters, const Transform& world_to_camera,
                                MediumHandle medium, const SourceLocation& where) {
    const Result<Transform> transform = settled_camera(world_to_camera, where);
    if (!transform) return transform.error();
    if (Status s = settings(scene_.camera, EntityKind::camera, type, std::move(parameters), where); !s) return s;
    if (Status s = resolve_files(scene_.camera.parameters); !s) return s;
    scene_.camera_to_world = transform->inverse();
    scene_.camera_moved_to.reset();
    scene_.camera_medium = medium.index;
    return success();
}

Status SceneBuilder::set_moving_camera(const std::string& type, SceneParameters parameters,
                                       const Transform& world_to_camera, const Transform& moved_to, MediumHandle medium,
                                       const SourceLocation& where) {
    const Result<Transform> last = settled_camera(moved_to, where);
    if (!last) return last.error();
    if (Status s = set_camera(type, std::move(parameters), world_to_camera, medium, where); !s) return s;
    scene_.camera_moved_to = last->inverse();
    if (const auto way = AnimatedTransform::between(scene_.camera_to_world, *scene_.camera_moved_to, where); !way)
        return way.error();
    return success();
}

Status SceneBuilder::set_transform_times(double start, double end, const SourceLocation& where) {
    if (!(start < end))
        return error_at(where, "the times of transformations are " + std::to_string(start) + " and " +
                                   std::to_string(end) + "; expected the earlier one first");
    scene_.transform_times = {start, end};
    return success();
}

Result<MaterialHandle> SceneBuilder::add_material(const std::string& type, SceneParameters parameters,
                                                  const SourceLocation& where) {
    Result<SceneEntity> entity = make_entity(material_type(type), EntityKind::material, std::move(parameters), where);
    if (!entity) return entity.error();
    scene_.materials.push_back(std::move(*entity));
    material_references_.push_back({static_cast<int>(scene_.materials.size()) - 1, {}, {}});
    return MaterialHandle{static_cast<int>(material_references_.size()) - 1};
}

Result<MaterialHandle> SceneBuilder::add_named_material(const SceneName& name, const std::string& type,
                                                        SceneParameters parameters, const SourceLocation& where) {
    if (const auto earlier = named_materials_.find(name.text); earlier != named_materials_.end())
        return defined_twice("material", name, where,
                             scene_.materials[static_cast<std::size_t>(earlier->second)].location);
    Result<SceneEntity> entity = make_entity(material_type(type), EntityKind::material, std::move(parameters), where);
    if (!entity) return entity.error();
    entity->name = name.text;
    named_materials_[name.text] = static_cast<int>(scene_.materials.size());
    scene_.materials.push_back(std::move(*entity));
    return material_named(name, where);
}

MaterialHandle SceneBuilder::material_named(const SceneName& name, const SourceLocation& where) {
    material_references_.push_back({-1, name.text, place_of(name, where)});
    return {static_cast<int>(material_references_.size()) - 1};
}

Result<MediumHandle> SceneBuilder::add_medium(const SceneName& name, const std::string& type,
                                              SceneParameters parameters, const Transform& to_world,
                                              const SourceLocation& where) {
    if (const auto earlier = named_media_.find(name.text); earlier != named_media_.end())
        return defined_twice("medium", name, where, scene_.media[static_cast<std::size_t>(earlier->second)].location);
    const Result<Transform> transform = settled(to_world, where);
    if (!transform) return transform.error();
    Result<SceneEntity> entity = make_entity(type, EntityKind::medium, std::move(parameters), where);
    if (!entity) return entity.error();
    SceneMedium medium;
    static_cast<SceneEntity&>(medium) = std::move(*entity);
    medium.name = name.text;
    medium.to_world = *transform;
    const int index = static_cast<int>(scene_.media.size());
    named_media_[name.text] = index;
    scene_.media.push_back(std::move(medium));
    return MediumHandle{index};
}

Result<MediumHandle> SceneBuilder::medium_named(const SceneName& name, const SourceLocation& where) const {
    if (const auto found = named_media_.find(name.text); found != named_media_.end())
        return MediumHandle{found->second};
    std::vector<std::string> known;
    for (const auto& [medium, index] : named_media_) known.push_back(medium);
    const std::string near = nearest_name(name.text, known);
    return error_at(place_of(name, where), "no medium is called '" + name.text + "'",
                    near.empty() ? "" : "did you mean '" + near + "'?");
}

Status SceneBuilder::add_texture(const SceneName& name, TextureValue value, const std::string& type,
                                 SceneParameters parameters, const Transform& to_world, const SourceLocation& where) {
    const bool spectrum = value == TextureValue::spectrum;
    auto& names = named_textures_[spectrum ? 1 : 0];
    if (const auto found = names.find(name.text); found != names.end())
        return defined_twice(spectrum ? "spectrum texture" : "float texture", name, where,
                             scene_.textures[found->second].location);
    const Result<Transform> transform = settled(to_world, where);
    if (!transform) return transform.error();
    Result<SceneEntity> entity = make_entity(type, EntityKind::texture, std::move(parameters), where, !spectrum);
    if (!entity) return entity.error();
    SceneTexture texture;
    static_cast<SceneEntity&>(texture) = std::move(*entity);
    texture.name = name.text;
    texture.spectrum = spectrum;
    texture.to_world = *transform;
    names.emplace(name.text, scene_.textures.size());
    scene_.textures.push_back(std::move(texture));
    return success();
}

Status SceneBuilder::add_light(const std::string& type, SceneParameters parameters, const Transform& to_world,
                               const std::string& group, const SourceLocation& where) {
    const Result<Transform> transform = settled(to_world, where);
    if (!transform) return transform.error();
    Result<SceneEntity> entity = make_entity(type, EntityKind::light, std::move(parameters), where);
    if (!entity) return entity.error();
    SceneLight light;
    static_cast<SceneEntity&>(light) = std::move(*entity);
    light.to_world = *transform;
    light.group = group;
    scene_.lights.push_back(std::move(light));
    return success();
}

Result<AreaLightHandle> SceneBuilder::add_area_light(const std::string& type, SceneParameters parameters,
                                                     const std::string& group, const SourceLocation& where) {
    Result<SceneEntity> entity = make_entity(type, EntityKind::area_light, std::move(parameters), where);
    if (!entity) return entity.error();
    SceneAreaLight light;
    static_cast<SceneEntity&>(light) = std::move(*entity);
    light.group = group;
    scene_.area_lights.push_back(std::move(light));
    return AreaLightHandle{static_cast<int>(scene_.area_lights.size()) - 1};
}

/// Shapes resolve their own files: a plymesh keeps the name as written for label rules.
Status SceneBuilder::add_shape(const std::string& type, SceneParameters parameters, const ShapePlacement& placement,
                               const SourceLocation& where) {
    if (placement.moved_to) {
        const auto still = as_moving_object(placement, where);
        if (!still) return still.error();
        return add_shape(type, std::move(parameters), *still, where);
    }
    const Result<Transform> transform = settled(placement.to_world, where);
    if (!transform) return transform.error();
    const Result<ParameterSet> set = checked(type, EntityKind::shape, std::move(parameters), where);
    if (!set) return set.error();
    if (const Parameter* file = set->find("filename"); missing_ == MissingFiles::placeholders && type == "plymesh" &&
                                                       file != nullptr && file->strings.size() == 1 &&
                                                       !search_.find(file->strings.front(), file->location))
        return place_missing_mesh(file->strings.front(), placement, where);
    Result<std::vector<SceneShape>> shapes =
        make_shapes(type, *set, {*transform, placement.reverse_orientation, search_}, scene_.warnings);
    if (!shapes) return shapes.error();
    return place(std::move(*shapes), placement, where);
}

Status SceneBuilder::add_mesh(const MeshData& mesh, const ShapePlacement& placement, const SourceLocation& where) {
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
    SceneShape shape;
    shape.kind = mesh.patches ? ShapeKind::bilinear_mesh : ShapeKind::triangle_mesh;
    shape.location = where;
    shape.positions = mesh.positions;
    shape.normals = mesh.normals;
    shape.uvs = mesh.uvs;
    shape.indices = mesh.indices;
    Result<std::vector<SceneShape>> shapes = finish_mesh(
        std::move(shape), "the mesh", {*transform, placement.reverse_orientation, search_}, scene_.warnings);
    if (!shapes) return shapes.error();
    return place(std::move(*shapes), placement, where);
}

Status SceneBuilder::add_curves(const CurveData& curves, const ShapePlacement& placement, const SourceLocation& where) {
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

/// A shape that moves is an object that has one instance: its placement in that object.
Result<ShapePlacement> SceneBuilder::as_moving_object(const ShapePlacement& placement, const SourceLocation& where) {
    if (placement.object.reference >= 0)
        return error_at(where, "a shape moves inside an object; expected the object's instances to move",
                        "ObjectInstance under a moving transformation places a moving object");
    if (placement.area_light.index >= 0)
        return error_at(where, "an area light moves; expected lights that stand still",
                        "the camera and everything else can move past it");
    std::string name;
    do name = "moving shape " + std::to_string(++moving_shapes_);
    while (named_objects_.count(name) != 0);
    const Result<ObjectHandle> object = add_object({name}, where);
    if (!object) return object.error();
    if (Status s = add_moving_instance(*object, placement.to_world, *placement.moved_to, where); !s) return s.error();
    ShapePlacement still = placement;
    still.to_world = Transform();
    still.moved_to.reset();
    still.object = *object;
    return still;
}

Status SceneBuilder::place(std::vector<SceneShape> shapes, const ShapePlacement& placement,
                           const SourceLocation& where) {
    const bool in_object = placement.object.reference >= 0;
    if (in_object && placement.area_light.index >= 0)
        warn(error_at(where, "area lights do not emit from object instances (pbrt's rule); this shape is dark"));
    std::vector<SceneShape>* target = &scene_.shapes;
    if (in_object) {
        const Reference& object = object_references_[static_cast<std::size_t>(placement.object.reference)];
        const auto found = named_objects_.find(object.name);
        if (found == named_objects_.end())
            return error_at(where, "the object '" + object.name + "' gets a shape before it is added");
        target = &scene_.objects[static_cast<std::size_t>(found->second)].shapes;
    }
    for (SceneShape& shape : shapes) {
        shape.material = placement.material.reference;  // a reference until finish()
        shape.area_light = in_object ? -1 : placement.area_light.index;
        shape.inside_medium = placement.inside.index;
        shape.outside_medium = placement.outside.index;
        shape.label = placement.label;
        const auto named = [this](const SceneShape& of) -> const Reference& {
            return material_references_[static_cast<std::size_t>(of.material)];
        };
        const auto same_material = [&](const SceneShape& other) {
            return named(other).index == named(shape).index && named(other).name == named(shape).name;
        };
        if (!target->empty() && join_curves(target->back(), shape, same_material(target->back()))) continue;
        target->push_back(std::move(shape));
    }
    return success();
}

Result<ObjectHandle> SceneBuilder::add_object(const SceneName& name, const SourceLocation& where) {
    if (!named_objects_.emplace(name.text, static_cast<int>(scene_.objects.size())).second)
        return error_at(place_of(name, where), "object '" + name.text + "' is defined twice");
    scene_.objects.push_back({name.text, {}});
    return object_named(name, where);
}

ObjectHandle SceneBuilder::object_named(const SceneName& name, const SourceLocation& where) {
    // A million instances of a few objects need a few references.
    const auto [found, fresh] = object_reference_of_.emplace(name.text, static_cast<int>(object_references_.size()));
    if (fresh) object_references_.push_back({-1, name.text, place_of(name, where)});
    return {found->second};
}

Status SceneBuilder::add_instance(ObjectHandle object, const Transform& to_world, const SourceLocation& where) {
    if (object.reference < 0) return error_at(where, "an instance of no object; expected one that was added or named");
    const Result<Transform> transform = settled(to_world, where);
    if (!transform) return transform.error();
    SceneInstance instance;
    instance.object = object.reference;  // a reference until finish()
    instance.to_world = *transform;
    instance.location = where;
    scene_.instances.push_back(std::move(instance));
    return success();
}

Status SceneBuilder::add_moving_instance(ObjectHandle object, const Transform& to_world, const Transform& moved_to,
                                         const SourceLocation& where) {
    const Result<Transform> last = settled(moved_to, where);
    if (!last) return last.error();
    if (Status s = add_instance(object, to_world, where); !s) return s;
    if (const auto way = AnimatedTransform::between(to_world, *last, where); !way) return way.error();
    scene_.instances.back().motion = static_cast<std::int32_t>(scene_.moved_to.size());
    scene_.moved_to.push_back(*last);
    return success();
}

}  // namespace raylex::transport
