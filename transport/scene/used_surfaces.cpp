#include "transport/scene/used_surfaces.h"

#include <algorithm>
#include <utility>

namespace raylex::transport {

namespace {

void append_found(const std::multimap<std::string_view, std::size_t>& names, const std::string& name,
                  std::vector<std::size_t>& found) {
    const auto [begin, end] = names.equal_range(name);
    for (auto each = begin; each != end; ++each) found.push_back(each->second);
}

}  // namespace

NamedSurfaces::NamedSurfaces(const SceneDescription& of) : scene(of) {
    for (std::size_t i = 0; i < scene.materials.size(); ++i)
        if (!scene.materials[i].name.empty()) materials.emplace(scene.materials[i].name, i);
    for (std::size_t i = 0; i < scene.textures.size(); ++i) textures.emplace(scene.textures[i].name, i);
}

void NamedSurfaces::append_textures(const ParameterSet& set, std::vector<std::size_t>& found) const {
    for (const Parameter& each : set.parameters)
        if (each.type == ParameterType::texture)
            for (const std::string& name : each.strings) append_found(textures, name, found);
}

UsedSurfaces::UsedSurfaces(const SceneDescription& scene)
    : material_seen_(scene.materials.size(), 0), texture_seen_(scene.textures.size(), 0) {
    const NamedSurfaces names(scene);
    for_each_shape(scene, [&](const SceneShape& shape) {
        shapes_.push_back(&shape);
        use_material(names, static_cast<std::size_t>(std::max(shape.material, 0)));
        if (shape.alpha_texture.empty()) return;
        std::vector<std::size_t> alpha;
        append_found(names.textures, shape.alpha_texture, alpha);
        use_textures(names, std::move(alpha));
    });
}

UsedSurfaces::UsedSurfaces(const NamedSurfaces& names, std::size_t material)
    : material_seen_(names.scene.materials.size(), 0), texture_seen_(names.scene.textures.size(), 0) {
    use_material(names, material);
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
    const NamedSurfaces names(scene);
    for (std::size_t i = 0; i < found.size(); ++i) {
        const UsedSurfaces used(names, i);
        found[i] = std::any_of(used.textures().begin(), used.textures().end(),
                               [](const SceneTexture* each) { return is_filtered_image(*each); });
    }
    return found;
}

// The materials that remain are in a list, the next one last: chains of mixes and of textures may be longer than the
// stack is deep.
void UsedSurfaces::use_material(const NamedSurfaces& names, std::size_t index) {
    std::vector<std::size_t> left{index};
    while (!left.empty()) {
        index = left.back();
        left.pop_back();
        if (index >= material_seen_.size() || material_seen_[index] != 0) continue;
        material_seen_[index] = 1;
        const SceneEntity& material = names.scene.materials[index];
        materials_.push_back(&material);
        std::vector<std::size_t> textures;
        names.append_textures(material.parameters, textures);
        use_textures(names, std::move(textures));
        const std::size_t first = left.size();
        if (material.type == "mix")
            for (const Parameter& each : material.parameters.parameters)
                if (each.name == "materials")
                    for (const std::string& name : each.strings) append_found(names.materials, name, left);
        std::reverse(left.begin() + static_cast<std::ptrdiff_t>(first), left.end());
    }
}

void UsedSurfaces::use_textures(const NamedSurfaces& names, std::vector<std::size_t> left) {
    std::reverse(left.begin(), left.end());
    while (!left.empty()) {
        const std::size_t index = left.back();
        left.pop_back();
        if (texture_seen_[index] != 0) continue;
        texture_seen_[index] = 1;
        textures_.push_back(&names.scene.textures[index]);
        const std::size_t first = left.size();
        names.append_textures(textures_.back()->parameters, left);
        std::reverse(left.begin() + static_cast<std::ptrdiff_t>(first), left.end());
    }
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
    std::map<std::string_view, bool> passed;  // by name, for the last material of that name so far
    // In the order in which materials are built: named ones use those before them, others use all.
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
