// What the shapes of a scene use: materials by way of mixes, and textures by way of both.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "transport/scene/scene_description.h"

namespace raylex::transport {

/// A scene's materials and textures by name, of which it may have thousands; those of one name in the scene's order.
struct NamedSurfaces {
    explicit NamedSurfaces(const SceneDescription& scene);
    /// The textures that parameters name.
    void append_textures(const ParameterSet& set, std::vector<std::size_t>& found) const;
    const SceneDescription& scene;
    std::multimap<std::string_view, std::size_t> materials, textures;  ///< indices
};

class UsedSurfaces {
  public:
    explicit UsedSurfaces(const SceneDescription& scene);
    /// Of one material alone.
    UsedSurfaces(const NamedSurfaces& names, std::size_t material);

    /// The scene's own, then those of every object, placed or not: all are built.
    [[nodiscard]] const std::vector<const SceneShape*>& shapes() const { return shapes_; }
    [[nodiscard]] const std::vector<const SceneEntity*>& materials() const { return materials_; }
    [[nodiscard]] const std::vector<const SceneTexture*>& textures() const { return textures_; }

  private:
    void use_material(const NamedSurfaces& names, std::size_t index);
    void use_textures(const NamedSurfaces& names, std::vector<std::size_t> left);

    std::vector<const SceneShape*> shapes_;
    std::vector<const SceneEntity*> materials_;
    std::vector<const SceneTexture*> textures_;
    std::vector<std::uint8_t> material_seen_, texture_seen_;
};

/// Calls `use(shape)` for the scene's own shapes, then for those of every object.
template <class Scene, class Use>
void for_each_shape(Scene& scene, const Use& use) {
    for (auto& shape : scene.shapes) use(shape);
    for (auto& object : scene.objects)
        for (auto& shape : object.shapes) use(shape);
}

/// An image texture that is looked up over what a pixel sees of it, and not at a point.
[[nodiscard]] bool is_filtered_image(const SceneTexture& texture);
/// Makes none of them one.
void read_images_unfiltered(SceneDescription& scene);
/// [material] whether it, or what it mixes, looks up such an image.
[[nodiscard]] std::vector<std::uint8_t> materials_with_filtered_images(const SceneDescription& scene);

/// No surface at all: pbrt's "interface", or a material without a type.
[[nodiscard]] bool is_interface(const SceneDescription& scene, const SceneShape& shape);
[[nodiscard]] bool is_interface(const SceneEntity& material);
/// [material] whether it is a mix, of mixes perhaps, that has an interface among its parts.
[[nodiscard]] std::vector<std::uint8_t> mixes_with_interface(const SceneDescription& scene);

}  // namespace raylex::transport
