// Directives after WorldBegin that add something to the scene.
#include <algorithm>

#include "transport/color/spectral_data.h"
#include "transport/import/scene_builder.h"
#include "transport/import/shapes.h"

namespace raylex::transport {

namespace {

bool names_a_file(const Parameter& parameter) {
    return parameter.type == ParameterType::string && (parameter.name == "filename" || parameter.name == "normalmap");
}

/// pbrt's three spellings of "nothing but a boundary".
std::string material_type(const std::string& written) {
    return written.empty() || written == "none" ? "interface" : written;
}

/// What Attribute calls entities of this kind.
const char* attribute_target(EntityKind kind) {
    switch (kind) {
        case EntityKind::material:
            return "material";
        case EntityKind::medium:
            return "medium";
        case EntityKind::texture:
            return "texture";
        default:
            return "light";
    }
}

/// Takes "string type" out of a MakeNamed... directive's parameters.
Result<std::string> take_type(Directive& directive, const std::string& kind, const std::string& example) {
    std::vector<Parameter>& parameters = directive.parameters.parameters;
    const auto type =
        std::find_if(parameters.begin(), parameters.end(), [](const Parameter& p) { return p.name == "type"; });
    if (type == parameters.end())
        return error_at(directive.location, "named " + kind + " '" + directive.strings[0] +
                                                "' has no type; expected \"string type\" \"" + example +
                                                "\" or the like");
    if (type->type != ParameterType::string || type->strings.size() != 1)
        return error_at(type->location, "'type' of a named " + kind + "; expected one \"string type\"");
    std::string written = type->strings.front();
    parameters.erase(type);
    return written;
}

}  // namespace

Status SceneBuilder::world_entity(Directive& directive, const SearchPath& search) {
    switch (directive.id) {
        case DirectiveId::material:
            return material(directive, search);
        case DirectiveId::make_named_material:
            return named_material(directive, search);
        case DirectiveId::named_material:
            material_references_.push_back({-1, directive.strings[0], directive.string_locations[0]});
            state_.material = material_references_.size() - 1;
            return success();
        case DirectiveId::texture:
            return texture(directive, search);
        case DirectiveId::light_source:
            return light(directive, search);
        case DirectiveId::area_light_source:
            return area_light(directive, search);
        case DirectiveId::shape:
            return shape(directive, search);
        case DirectiveId::object_begin:
            return object_begin(directive);
        case DirectiveId::object_instance:
            return instance(directive);
        default:
            break;
    }
    return error_at(directive.location, std::string(directive.name) + " is not handled");
}

/// Own parameters first; those set by Attribute fill the gaps. Colours end up in the film's space, files absolute.
Result<SceneEntity> SceneBuilder::make_entity(Directive& directive, std::string type, EntityKind kind,
                                              const SearchPath& search) {
    // A medium's colours are those of a light, "Le"; its coefficients are none.
    const bool light = kind != EntityKind::material && kind != EntityKind::texture;
    SceneEntity entity;
    entity.type = std::move(type);
    entity.location = directive.location;
    entity.parameters = std::move(directive.parameters);
    const std::size_t own = entity.parameters.parameters.size();
    convert_colors(entity.parameters, scene_.color.scene_space, state_.color_space, light);
    const auto found = state_.defaults->find(attribute_target(kind));
    if (found != state_.defaults->end()) {
        for (const DefaultParameter& fallback : found->second) {
            if (std::any_of(entity.parameters.parameters.begin(), entity.parameters.parameters.end(),
                            [&](const Parameter& p) { return p.name == fallback.parameter.name; }))
                continue;
            ParameterSet one;
            one.parameters.push_back(fallback.parameter);
            convert_colors(one, scene_.color.scene_space, fallback.space, light);
            entity.parameters.parameters.push_back(std::move(one.parameters.front()));
        }
    }
    if (Status s = parameters_.check(kind, entity.type, entity.parameters, own, scene_.warnings); !s) return s.error();
    if (Status status = resolve_files(entity.parameters, search); !status) return status.error();
    return entity;
}

Status SceneBuilder::resolve_files(ParameterSet& set, const SearchPath& search) const {
    for (Parameter& parameter : set.parameters) {
        const bool spectrum = parameter.type == ParameterType::spectrum;
        if (!spectrum && !names_a_file(parameter)) continue;
        for (std::string& name : parameter.strings) {
            VisibleSpectrum unused{};
            if (spectrum && find_named_spectrum(name, unused)) continue;
            Result<std::string> path = search.find(name, parameter.location);
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

Status SceneBuilder::material(Directive& directive, const SearchPath& search) {
    Result<SceneEntity> entity =
        make_entity(directive, material_type(directive.strings[0]), EntityKind::material, search);
    if (!entity) return entity.error();
    scene_.materials.push_back(std::move(*entity));
    material_references_.push_back({static_cast<int>(scene_.materials.size()) - 1, {}, {}});
    state_.material = material_references_.size() - 1;
    return success();
}

Status SceneBuilder::named_material(Directive& directive, const SearchPath& search) {
    const std::string name = directive.strings[0];
    const Result<std::string> written = take_type(directive, "material", "diffuse");
    if (!written) return written.error();
    if (const auto earlier = named_materials_.find(name); earlier != named_materials_.end()) {
        const SourceLocation& where = scene_.materials[static_cast<std::size_t>(earlier->second)].location;
        return error_at(directive.string_locations[0], "material '" + name + "' is defined twice; the first is at " +
                                                           where.file + ":" + std::to_string(where.line));
    }
    Result<SceneEntity> entity = make_entity(directive, material_type(*written), EntityKind::material, search);
    if (!entity) return entity.error();
    entity->name = name;
    named_materials_[name] = static_cast<int>(scene_.materials.size());
    scene_.materials.push_back(std::move(*entity));
    return success();
}

Status SceneBuilder::named_medium(Directive& directive, const SearchPath& search) {
    const std::string name = directive.strings[0];
    if (const auto earlier = named_media_.find(name); earlier != named_media_.end()) {
        const SourceLocation& where = scene_.media[static_cast<std::size_t>(earlier->second)].location;
        return error_at(directive.string_locations[0], "medium '" + name + "' is defined twice; the first is at " +
                                                           where.file + ":" + std::to_string(where.line));
    }
    const Result<std::string> type = take_type(directive, "medium", "homogeneous");
    if (!type) return type.error();
    Result<SceneEntity> entity = make_entity(directive, *type, EntityKind::medium, search);
    if (!entity) return entity.error();
    entity->name = name;
    named_media_[name] = static_cast<int>(scene_.media.size());
    scene_.media.push_back(std::move(*entity));
    return success();
}

Status SceneBuilder::texture(Directive& directive, const SearchPath& search) {
    const std::string &name = directive.strings[0], &value = directive.strings[1];
    if (value != "float" && value != "spectrum")
        return error_at(directive.string_locations[1],
                        "texture '" + name + "' has value type '" + value + "'; expected \"float\" or \"spectrum\"");
    auto& names = named_textures_[value == "spectrum" ? 1 : 0];
    if (const auto found = names.find(name); found != names.end()) {
        const SourceLocation& earlier = scene_.textures[found->second].location;
        return error_at(directive.string_locations[0], value + " texture '" + name +
                                                           "' is defined twice; the first is at " + earlier.file + ":" +
                                                           std::to_string(earlier.line));
    }
    const Result<Transform> transform = still_transform(directive.location);
    if (!transform) return transform.error();
    Result<SceneEntity> entity = make_entity(directive, directive.strings[2], EntityKind::texture, search);
    if (!entity) return entity.error();
    SceneTexture texture;
    static_cast<SceneEntity&>(texture) = std::move(*entity);
    texture.name = name;
    texture.spectrum = value == "spectrum";
    texture.to_world = *transform;
    names.emplace(name, scene_.textures.size());
    scene_.textures.push_back(std::move(texture));
    return success();
}

Status SceneBuilder::light(Directive& directive, const SearchPath& search) {
    const Result<Transform> transform = still_transform(directive.location);
    if (!transform) return transform.error();
    Result<SceneEntity> entity = make_entity(directive, directive.strings[0], EntityKind::light, search);
    if (!entity) return entity.error();
    SceneLight light;
    static_cast<SceneEntity&>(light) = std::move(*entity);
    light.to_world = *transform;
    scene_.lights.push_back(std::move(light));
    return success();
}

Status SceneBuilder::area_light(Directive& directive, const SearchPath& search) {
    Result<SceneEntity> entity = make_entity(directive, directive.strings[0], EntityKind::area_light, search);
    if (!entity) return entity.error();
    SceneAreaLight light;
    static_cast<SceneEntity&>(light) = std::move(*entity);
    state_.area_light = static_cast<int>(scene_.area_lights.size());
    scene_.area_lights.push_back(std::move(light));
    return success();
}

Status SceneBuilder::shape(Directive& directive, const SearchPath& search) {
    const Result<Transform> transform = still_transform(directive.location);
    if (!transform) return transform.error();
    const std::size_t own = directive.parameters.parameters.size();
    // Shapes resolve their own files: a plymesh keeps the name as written for label rules.
    ParameterSet set = std::move(directive.parameters);
    if (const auto found = state_.defaults->find("shape"); found != state_.defaults->end())
        for (const DefaultParameter& fallback : found->second)
            if (std::none_of(set.parameters.begin(), set.parameters.end(),
                             [&](const Parameter& p) { return p.name == fallback.parameter.name; }))
                set.parameters.push_back(fallback.parameter);
    if (Status s = parameters_.check(EntityKind::shape, directive.strings[0], set, own, scene_.warnings); !s) return s;
    Result<std::vector<SceneShape>> shapes =
        make_shapes(directive.strings[0], set, {*transform, state_.reverse_orientation, search}, scene_.warnings);
    if (!shapes) return shapes.error();
    const bool emits = state_.area_light >= 0;
    if (emits && active_object_ >= 0)
        scene_.warnings.push_back(error_at(
            directive.location, "area lights do not emit from object instances (pbrt's rule); this shape is dark"));
    for (SceneShape& shape : *shapes) {
        shape.material = static_cast<int>(state_.material);  // a reference until finish()
        shape.area_light = active_object_ >= 0 ? -1 : state_.area_light;
        shape.inside_medium = state_.inside_medium;
        shape.outside_medium = state_.outside_medium;
        auto& target =
            active_object_ >= 0 ? scene_.objects[static_cast<std::size_t>(active_object_)].shapes : scene_.shapes;
        target.push_back(std::move(shape));
    }
    return success();
}

Status SceneBuilder::object_begin(const Directive& directive) {
    const std::string& name = directive.strings[0];
    if (active_object_ >= 0)
        return error_at(directive.location, "ObjectBegin inside ObjectBegin; expected ObjectEnd first");
    if (!object_names_.insert(name).second)
        return error_at(directive.string_locations[0], "object '" + name + "' is defined twice");
    if (Status status = begin_block(Block::object, directive.location); !status) return status;
    active_object_ = static_cast<int>(scene_.objects.size());
    scene_.objects.push_back({name, {}});
    return success();
}

Status SceneBuilder::instance(const Directive& directive) {
    if (active_object_ >= 0)
        return error_at(directive.location, "ObjectInstance inside ObjectBegin; objects cannot be nested");
    const Result<Transform> transform = still_transform(directive.location);
    if (!transform) return transform.error();
    SceneInstance instance;
    instance.to_world = *transform;
    instance.location = directive.location;
    scene_.instances.push_back(std::move(instance));
    instance_references_.push_back({directive.strings[0], directive.string_locations[0]});
    return success();
}

}  // namespace raylex::transport
