// Directives after WorldBegin that add entities to the scene.
#include <algorithm>

#include "transport/import/pbrt/scene_reader.h"
#include "transport/scene/typed_parameters.h"

namespace raylex::transport {

namespace {

/// Removes "string type" from the parameters of a MakeNamed... directive and returns it.
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

Status SceneReader::world_entity(Directive& directive) {
    switch (directive.id) {
        case DirectiveId::material:
            return material(directive);
        case DirectiveId::make_named_material:
            return named_material(directive);
        case DirectiveId::named_material:
            state_.material = scene_.material_named({directive.strings[0], directive.string_locations[0]});
            return success();
        case DirectiveId::texture:
            return texture(directive);
        case DirectiveId::light_source:
            return light(directive);
        case DirectiveId::area_light_source:
            return area_light(directive);
        case DirectiveId::shape:
            return shape(directive);
        case DirectiveId::object_begin:
            return object_begin(directive);
        case DirectiveId::object_instance:
            return instance(directive);
        default:
            break;
    }
    return error_at(directive.location, std::string(directive.name) + " is not handled");
}

/// The directive's own parameters, then those set by Attribute for `target` (its name for this kind of entity). Colours
/// are converted to the film's space; a medium's "Le" is converted like a light.
SceneParameters SceneReader::with_defaults(Directive& directive, const char* target, bool light) const {
    SceneParameters result(std::move(directive.parameters));
    convert_colors(result.own, scene_.color_space(), state_.color_space, light);
    const auto found = state_.defaults->find(target);
    if (found == state_.defaults->end()) return result;
    for (const DefaultParameter& fallback : found->second) {
        ParameterSet one;
        one.parameters.push_back(fallback.parameter);
        convert_colors(one, scene_.color_space(), fallback.space, light);
        result.fallbacks.push_back(std::move(one.parameters.front()));
    }
    return result;
}

Status SceneReader::material(Directive& directive) {
    const Result<MaterialHandle> made =
        scene_.add_material(directive.strings[0], with_defaults(directive, "material", false), directive.location);
    if (!made) return made.error();
    state_.material = *made;
    return success();
}

Status SceneReader::named_material(Directive& directive) {
    const Result<std::string> type = take_type(directive, "material", "diffuse");
    if (!type) return type.error();
    const Result<MaterialHandle> made =
        scene_.add_named_material({directive.strings[0], directive.string_locations[0]}, *type,
                                  with_defaults(directive, "material", false), directive.location);
    if (!made) return made.error();
    return success();
}

Status SceneReader::named_medium(Directive& directive) {
    const Result<std::string> type = take_type(directive, "medium", "homogeneous");
    if (!type) return type.error();
    const Result<MediumHandle> made = scene_.add_medium(
        {directive.strings[0], directive.string_locations[0]}, *type, with_defaults(directive, "medium", true),
        first_transform("media", directive.location), directive.location);
    if (!made) return made.error();
    return success();
}

Status SceneReader::texture(Directive& directive) {
    const std::string &name = directive.strings[0], &value = directive.strings[1];
    if (value != "float" && value != "spectrum")
        return error_at(directive.string_locations[1],
                        "texture '" + name + "' has value type '" + value + "'; expected \"float\" or \"spectrum\"");
    return scene_.add_texture({name, directive.string_locations[0]},
                              value == "spectrum" ? TextureValue::spectrum : TextureValue::real, directive.strings[2],
                              with_defaults(directive, "texture", false),
                              first_transform("textures", directive.location), directive.location);
}

/// Lights without a colour emit the white of their own colour space.
SceneParameters SceneReader::light_parameters(Directive& directive) const {
    SceneParameters result = with_defaults(directive, "light", true);
    if (state_.color_space == scene_.color_space()) return result;
    ParameterSet white;
    white.parameters.push_back(typed::rgb("I", {1, 1, 1}));
    const bool has_image =
        result.own.find("filename") != nullptr || std::any_of(result.fallbacks.begin(), result.fallbacks.end(),
                                                              [](const Parameter& p) { return p.name == "filename"; });
    if (!has_image) white.parameters.push_back(typed::rgb("L", {1, 1, 1}));
    convert_colors(white, scene_.color_space(), state_.color_space, true);
    for (Parameter& parameter : white.parameters) {
        parameter.location = directive.location;
        result.fallbacks.push_back(std::move(parameter));
    }
    return result;
}

Status SceneReader::light(Directive& directive) {
    return scene_.add_light(directive.strings[0], light_parameters(directive),
                            first_transform("lights", directive.location), {}, directive.location);
}

Status SceneReader::area_light(Directive& directive) {
    const Result<AreaLightHandle> made =
        scene_.add_area_light(directive.strings[0], light_parameters(directive), {}, directive.location);
    if (!made) return made.error();
    state_.area_light = *made;
    return success();
}

Status SceneReader::shape(Directive& directive) {
    SceneParameters parameters(std::move(directive.parameters));
    if (const auto found = state_.defaults->find("shape"); found != state_.defaults->end())
        for (const DefaultParameter& fallback : found->second) parameters.fallbacks.push_back(fallback.parameter);
    return scene_.add_shape(directive.strings[0], std::move(parameters),
                            {.to_world = state_.ctm[0],
                             .moved_to = moves() ? std::optional(state_.ctm[1]) : std::nullopt,
                             .material = state_.material,
                             .area_light = state_.area_light,
                             .inside = state_.inside_medium,
                             .outside = state_.outside_medium,
                             .reverse_orientation = state_.reverse_orientation,
                             .object = active_object_},
                            directive.location);
}

Status SceneReader::object_begin(const Directive& directive) {
    if (active_object_.reference >= 0)
        return error_at(directive.location, "ObjectBegin inside ObjectBegin; expected ObjectEnd first");
    const Result<ObjectHandle> object =
        scene_.add_object({directive.strings[0], directive.string_locations[0]}, directive.location);
    if (!object) return object.error();
    if (Status status = begin_block(Block::object, directive.location); !status) return status;
    active_object_ = *object;
    return success();
}

Status SceneReader::instance(const Directive& directive) {
    if (active_object_.reference >= 0)
        return error_at(directive.location, "ObjectInstance inside ObjectBegin; objects cannot be nested");
    const ObjectHandle object = scene_.object_named({directive.strings[0], directive.string_locations[0]});
    if (moves()) return scene_.add_moving_instance(object, state_.ctm[0], state_.ctm[1], directive.location);
    return scene_.add_instance(object, state_.ctm[0], directive.location);
}

/// A missing WorldBegin is reported at `file_end`.
Result<SceneDescription> SceneReader::finish(const SourceLocation& file_end) {
    if (!stack_.empty()) {
        const bool object = stack_.back().block == Block::object;
        return error_at(stack_.back().opened,
                        std::string(object ? "ObjectBegin" : "AttributeBegin") + " is never closed; expected " +
                            (object ? "ObjectEnd" : "AttributeEnd") + " before the end of the scene");
    }
    if (!in_world_)
        return error_at(file_end, "the scene ends before WorldBegin; expected WorldBegin and the scene's content");
    return scene_.finish();
}

}  // namespace raylex::transport
