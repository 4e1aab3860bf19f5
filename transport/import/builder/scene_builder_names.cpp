// At the end of a scene, every name that was used must be defined.
#include "transport/import/builder/scene_builder.h"
#include "transport/scene/film_sensor.h"
#include "transport/scene/used_surfaces.h"

namespace raylex::transport {

namespace {

std::string did_you_mean(const std::string& name, const std::vector<std::string>& known) {
    return known.empty() ? "none is defined" : near_miss(name, known);
}

/// Calls the function for each shape until the first failure.
template <typename Function>
Status for_each_shape(SceneDescription& scene, const Function& function) {
    for (SceneShape& shape : scene.shapes)
        if (Status status = function(shape); !status) return status;
    for (SceneObject& object : scene.objects)
        for (SceneShape& shape : object.shapes)
            if (Status status = function(shape); !status) return status;
    return success();
}

}  // namespace

Result<SceneDescription> SceneBuilder::finish(const SourceLocation& where) {
    if (Status status = check_open(where); !status) return status.error();
    const auto settle = [this]() -> Status {
        for (Status (SceneBuilder::*step)() :
             {&SceneBuilder::read_meshes, &SceneBuilder::place_moving_parts, &SceneBuilder::resolve_materials,
              &SceneBuilder::resolve_media, &SceneBuilder::resolve_objects})
            if (Status status = (this->*step)(); !status) return status;
        return check_textures();
    };
    const Status settled = settle();
    spent_ = true;  // after a failure, names are half resolved and meshes half read
    if (!settled) return settled.error();
    const auto sensor = read_sensor(scene_.film, scene_.camera, scene_.color.scene_space, scene_.warnings);
    if (!sensor) return sensor.error();
    scene_.color.sensor = sensor->recorded;
    scene_.color.measured = sensor->measured;
    if (unfiltered_) read_images_unfiltered(scene_);
    for (auto* names : {&named_materials_, &named_media_, &named_objects_})
        names->clear();  // the handles behind the names are no longer valid
    for (auto& names : named_textures_) names.clear();
    return std::move(scene_);
}

Status SceneBuilder::resolve_materials() {
    std::vector<std::string> known;
    for (const auto& [name, index] : named_materials_) known.push_back(name);
    const auto missing = [&](const std::string& name, const SourceLocation& where) {
        return error_at(where, "no material is called '" + name + "'", did_you_mean(name, known));
    };
    for (const SceneEntity& material : scene_.materials) {
        if (material.type != "mix") continue;
        for (const Parameter& parameter : material.parameters.parameters) {
            if (parameter.name != "materials") continue;
            for (const std::string& name : parameter.strings)
                if (named_materials_.count(name) == 0 && name != "interface" && !name.empty())
                    return missing(name, parameter.location);
        }
    }
    // Materials that no shape uses need not exist, as in pbrt.
    return for_each_shape(scene_, [&](SceneShape& shape) -> Status {
        Reference& reference = material_references_[static_cast<std::size_t>(shape.material)];
        if (reference.index < 0) {
            const auto found = named_materials_.find(reference.name);
            if (found == named_materials_.end()) return missing(reference.name, reference.location);
            reference.index = found->second;
        }
        shape.material = reference.index;
        if (shape.label.empty()) shape.label = scene_.materials[static_cast<std::size_t>(shape.material)].name;
        if (shape.area_light >= 0 && is_interface(scene_, shape)) {
            warn(error_at(shape.location,
                          "area lights do not emit from shapes without a surface (pbrt's rule); this shape is dark",
                          "its material is 'interface'; expected one with a surface, such as diffuse"));
            shape.area_light = -1;
        }
        return success();
    });
}

Status SceneBuilder::resolve_media() {
    const auto settle = [this](int& medium) -> Status {
        if (medium < 0) return success();
        const Reference& reference = media_references_[static_cast<std::size_t>(medium)];
        const auto found = named_media_.find(reference.name);
        if (found == named_media_.end()) {
            std::vector<std::string> known;
            for (const auto& [name, index] : named_media_) known.push_back(name);
            return error_at(reference.location, "no medium is called '" + reference.name + "'",
                            did_you_mean(reference.name, known));
        }
        medium = found->second;
        return success();
    };
    if (Status status = settle(scene_.camera_medium); !status) return status;
    return for_each_shape(scene_, [&](SceneShape& shape) {
        const Status status = settle(shape.inside_medium);
        return status ? settle(shape.outside_medium) : status;
    });
}

Status SceneBuilder::resolve_objects() {
    std::vector<std::string> known;
    for (const SceneObject& object : scene_.objects) known.push_back(object.name);
    for (SceneInstance& instance : scene_.instances) {
        const Reference& reference = object_references_[static_cast<std::size_t>(instance.object)];
        const auto found = named_objects_.find(reference.name);
        if (found == named_objects_.end())
            return error_at(reference.location, "no object is called '" + reference.name + "'",
                            did_you_mean(reference.name, known));
        instance.object = found->second;
    }
    return success();
}

bool SceneBuilder::has_texture(const std::string& name, bool spectrum, bool any_kind, std::size_t before) const {
    const auto among = [&](bool kind) {
        const auto& names = named_textures_[kind ? 1 : 0];
        const auto found = names.find(name);
        return found != names.end() && found->second < before;
    };
    return among(spectrum) || (any_kind && among(!spectrum));
}

Error SceneBuilder::no_such_texture(const std::string& name, const SourceLocation& where, const char* kind) const {
    std::vector<std::string> known;
    for (const SceneTexture& texture : scene_.textures) known.push_back(texture.name);
    const std::string near = nearest_name(name, known);
    return error_at(
        where, std::string("no ") + kind + "texture is called '" + name + "'",
        near == name ? "'" + name + "' is defined later or with the other value type" : did_you_mean(name, known));
}

// A texture may use those before it and those that texture_may_come_later() allows; materials and shapes may use all.
Status SceneBuilder::check_textures() const {
    const auto check_set = [this](const ParameterSet& set, std::size_t before, const SceneTexture* user) -> Status {
        const auto comes_later = [&](const std::string& name) {
            return user != nullptr &&
                   std::any_of(scene_.textures.begin(), scene_.textures.end(), [&](const auto& each) {
                       return each.name == name && texture_may_come_later(*user, each);
                   });
        };
        for (const Parameter& parameter : set.parameters) {
            if (parameter.type != ParameterType::texture) continue;
            for (const std::string& name : parameter.strings)
                if (!has_texture(name, false, true, before) && !comes_later(name))
                    return no_such_texture(name, parameter.location, "");
        }
        return success();
    };
    for (std::size_t i = 0; i < scene_.textures.size(); ++i)
        if (Status status = check_set(scene_.textures[i].parameters, i, &scene_.textures[i]); !status) return status;
    for (const SceneEntity& material : scene_.materials)
        if (Status status = check_set(material.parameters, scene_.textures.size(), nullptr); !status) return status;
    for (const SceneShape& shape : scene_.shapes)
        if (Status status = check_shape(shape); !status) return status;
    for (const SceneObject& object : scene_.objects)
        for (const SceneShape& shape : object.shapes)
            if (Status status = check_shape(shape); !status) return status;
    return success();
}

Status SceneBuilder::check_shape(const SceneShape& shape) const {
    for (const std::string& name : {shape.alpha_texture, shape.displacement_texture})
        if (!name.empty() && !has_texture(name, false, false, scene_.textures.size()))
            return no_such_texture(name, shape.location, "float ");
    return success();
}

}  // namespace raylex::transport
