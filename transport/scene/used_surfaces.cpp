#include "transport/scene/used_surfaces.h"

#include <algorithm>
#include <map>
#include <string_view>

namespace raylex::transport {

UsedSurfaces::UsedSurfaces(const SceneDescription& scene)
    : material_seen_(scene.materials.size(), 0), texture_seen_(scene.textures.size(), 0) {
    for_each_shape(scene, [&](const SceneShape& shape) {
        shapes_.push_back(&shape);
        use_material(scene, static_cast<std::size_t>(std::max(shape.material, 0)));
        if (!shape.alpha_texture.empty()) use_texture(scene, shape.alpha_texture);
    });
}

UsedSurfaces::UsedSurfaces(const SceneDescription& scene, std::size_t material)
    : material_seen_(scene.materials.size(), 0), texture_seen_(scene.textures.size(), 0) {
    use_material(scene, material);
}

bool is_filtered_image(const SceneTexture& texture) {
    if (texture.type != "imagemap") return false;
    const auto filter = texture.parameters.string_or("filter", "bilinear");
    return filter && *filter != "unfiltered";
}

void read_images_unfiltered(SceneDescription& scene) {
    for (SceneTexture& texture : scene.textures) {
        if (!is_filtered_image(texture)) continue;
        std::erase_if(texture.parameters.parameters, [](const Parameter& each) { return each.name == "filter"; });
        Parameter filter;
        filter.name = "filter";
        filter.type = ParameterType::string;
        filter.strings = {"unfiltered"};
        filter.location = texture.location;
        texture.parameters.parameters.push_back(std::move(filter));
    }
}

std::vector<std::uint8_t> materials_with_filtered_images(const SceneDescription& scene) {
    std::vector<std::uint8_t> found(scene.materials.size(), 0);
    if (std::none_of(scene.textures.begin(), scene.textures.end(), is_filtered_image)) return found;
    for (std::size_t i = 0; i < found.size(); ++i) {
        const UsedSurfaces used(scene, i);
        found[i] = std::any_of(used.textures().begin(), used.textures().end(),
                               [](const SceneTexture* each) { return is_filtered_image(*each); });
    }
    return found;
}

void UsedSurfaces::use_material(const SceneDescription& scene, std::size_t index) {
    if (index >= material_seen_.size() || material_seen_[index] != 0) return;
    material_seen_[index] = 1;
    const SceneEntity& material = scene.materials[index];
    materials_.push_back(&material);
    use_textures_of(scene, material.parameters);
    if (material.type != "mix") return;
    for (const Parameter& each : material.parameters.parameters)
        if (each.name == "materials")
            for (const std::string& name : each.strings)
                for (std::size_t i = 0; i < scene.materials.size(); ++i)
                    if (!name.empty() && scene.materials[i].name == name) use_material(scene, i);
}

void UsedSurfaces::use_texture(const SceneDescription& scene, const std::string& name) {
    for (std::size_t i = 0; i < texture_seen_.size(); ++i) {
        if (scene.textures[i].name != name || texture_seen_[i] != 0) continue;
        texture_seen_[i] = 1;
        textures_.push_back(&scene.textures[i]);
        use_textures_of(scene, scene.textures[i].parameters);
    }
}

void UsedSurfaces::use_textures_of(const SceneDescription& scene, const ParameterSet& set) {
    for (const Parameter& each : set.parameters)
        if (each.type == ParameterType::texture)
            for (const std::string& name : each.strings) use_texture(scene, name);
}

bool is_interface(const SceneEntity& material) {
    return material.type == "interface" || material.type.empty();
}

bool is_interface(const SceneDescription& scene, const SceneShape& shape) {
    const auto material = static_cast<std::size_t>(std::max(shape.material, 0));
    return material < scene.materials.size() && is_interface(scene.materials[material]);
}

std::vector<std::uint8_t> mixes_with_interface(const SceneDescription& scene) {
    std::vector<std::uint8_t> found(scene.materials.size(), 0);
    std::map<std::string_view, bool> passed;  // by name, of the last so far
    // As materials are built: named ones use those before them, others all.
    for (const bool named : {true, false})
        for (std::size_t i = 0; i < found.size(); ++i) {
            const SceneEntity& material = scene.materials[i];
            if (material.name.empty() == named) continue;
            const Parameter* parts = material.type == "mix" ? material.parameters.find("materials") : nullptr;
            if (parts != nullptr)
                for (const std::string& part : parts->strings)
                    if (const auto known = passed.find(part); known != passed.end() && known->second) found[i] = 1;
            if (named) passed[material.name] = found[i] != 0 || is_interface(material);
        }
    return found;
}

}  // namespace raylex::transport
