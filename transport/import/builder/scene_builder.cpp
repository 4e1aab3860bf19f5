#include "transport/import/builder/scene_builder.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "display/services/short_number.h"
#include "transport/cameras/aperture.h"
#include "transport/color/spectral_data.h"
#include "transport/import/builder/parameter_values.h"
#include "transport/import/builder/settled_transform.h"
#include "transport/import/known_types.h"
#include "transport/math/animated_transform.h"

namespace raylex::transport {

namespace {

bool names_a_file(const Parameter& parameter) {
    return parameter.type == ParameterType::string &&
           (parameter.name == "filename" || parameter.name == "normalmap" || parameter.name == "lensfile" ||
            (parameter.name == "aperture" && !parameter.strings.empty() &&
             !Aperture::is_built_in(parameter.strings.front())));
}

/// Maps pbrt's three spellings of a material without a surface to "interface".
std::string material_type(const std::string& written) {
    return written.empty() || written == "none" ? "interface" : written;
}

Error defined_twice(const std::string& what, const SceneName& name, const SourceLocation& where,
                    const SourceLocation& first) {
    return error_at(name.place(where), what + " '" + name.text + "' is defined twice; the first is at " + first.file +
                                           ":" + std::to_string(first.line));
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

/// Checks the parameters and returns the known ones, those of the directive itself first.
Result<ParameterSet> SceneBuilder::checked(const std::string& type, EntityKind kind, SceneParameters parameters,
                                           const SourceLocation& where, bool float_texture) {
    if (Status s = check_open(where); !s) return s.error();
    ParameterSet set = std::move(parameters.own);
    if (set.location.file.empty()) set.location = where;
    for (Parameter& parameter : set.parameters)
        if (parameter.location.file.empty()) parameter.location = where;
    const std::size_t own = set.parameters.size();
    // Compared with the directive's own parameters only: there may be thousands of fallbacks, and no two have the same
    // name.
    for (Parameter& fallback : parameters.fallbacks)
        if (std::none_of(set.parameters.begin(), set.parameters.begin() + static_cast<std::ptrdiff_t>(own),
                         [&](const Parameter& p) { return p.name == fallback.name; }))
            set.parameters.push_back(std::move(fallback));
    for (const Parameter& parameter : set.parameters)
        if (Status s = check_values(parameter); !s) return s.error();
    if (Status s = parameters_.check(kind, type, set, own, scene_.warnings); !s) return s.error();
    use_known_types(kind, type, float_texture, set);
    return set;
}

Result<SceneEntity> SceneBuilder::make_entity(const std::string& type, EntityKind kind, SceneParameters parameters,
                                              const SourceLocation& where, bool float_texture) {
    SceneEntity entity;
    entity.type = type;
    entity.location = where;
    Result<ParameterSet> set = checked(type, kind, std::move(parameters), where, float_texture);
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
    if (Status s = check_handle(medium, "medium", where); !s) return s;
    const Result<Transform> transform = settled_camera(world_to_camera, where);
    if (!transform) return transform.error();
    if (Status s = settings(scene_.camera, EntityKind::camera, type, std::move(parameters), where); !s) return s;
    if (Status s = resolve_files(scene_.camera.parameters); !s) return s;
    scene_.camera_to_world = transform->inverse();
    scene_.camera_moved_to.reset();
    scene_.camera_medium = medium.reference;  // resolved in finish()
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
    const std::string times = "the transformation times are " + short_number(start, 6) + " and " + short_number(end, 6);
    if (!std::isfinite(start) || !std::isfinite(end)) return error_at(where, times + "; expected finite ones");
    if (!(start < end)) return error_at(where, times + "; expected the earlier one first");
    scene_.transform_times = {start, end};
    return success();
}

Status SceneBuilder::scale_displacement_edges(double factor, const SourceLocation& where) {
    if (!(factor > 0) || !std::isfinite(factor))
        return error_at(
            where,
            "the factor of the edge lengths of displaced meshes is not above 0 and finite; expected a positive number");
    edge_scale_ = factor;
    return success();
}

Result<MaterialHandle> SceneBuilder::add_material(const std::string& type, SceneParameters parameters,
                                                  const SourceLocation& where) {
    Result<SceneEntity> entity = make_entity(material_type(type), EntityKind::material, std::move(parameters), where);
    if (!entity) return entity.error();
    scene_.materials.push_back(std::move(*entity));
    material_references_.push_back({static_cast<int>(scene_.materials.size()) - 1, {}, {}});
    return handle<MaterialHandle>(static_cast<int>(material_references_.size()) - 1);
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
    material_references_.push_back({-1, name.text, name.place(where)});
    return handle<MaterialHandle>(static_cast<int>(material_references_.size()) - 1);
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
    named_media_[name.text] = static_cast<int>(scene_.media.size());
    scene_.media.push_back(std::move(medium));
    return medium_named(name, where);
}

MediumHandle SceneBuilder::medium_named(const SceneName& name, const SourceLocation& where) {
    const auto [found, fresh] = medium_reference_of_.emplace(name.text, static_cast<int>(media_references_.size()));
    if (fresh) media_references_.push_back({-1, name.text, name.place(where)});
    return handle<MediumHandle>(found->second);
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
    if (!entity) {
        Error error = entity.error();  // finding the file would not help
        if (type == "ptex") error.hint += "; raylex does not read ptex files: imagemap reads images";
        return error;
    }
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
    return handle<AreaLightHandle>(static_cast<int>(scene_.area_lights.size()) - 1);
}

}  // namespace raylex::transport
