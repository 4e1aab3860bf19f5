// The materials and textures that the shapes of a scene use, including those reached through mixes and other textures.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "transport/scene/scene_description.h"

namespace raylex::transport {

/// A scene's materials and textures by name, of which there may be thousands; those of equal names in the scene's
/// order.
struct NamedSurfaces {
    explicit NamedSurfaces(const SceneDescription& scene);
    /// Appends the textures that the parameters name.
    void append_textures(const ParameterSet& set, std::vector<std::size_t>& found) const;
    const SceneDescription& scene;
    std::multimap<std::string_view, std::size_t> materials, textures;  ///< indices
};

class UsedSurfaces {
  public:
    explicit UsedSurfaces(const SceneDescription& scene);
    /// The surfaces that one material uses.
    UsedSurfaces(const NamedSurfaces& names, std::size_t material);

    /// The scene's own shapes, then those of every object, whether placed or not, since all are built.
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

/// Whether an image texture is filtered over a pixel's footprint instead of being looked up at a point.
[[nodiscard]] bool is_filtered_image(const SceneTexture& texture);
/// Disables filtering of all image textures.
void read_images_unfiltered(SceneDescription& scene);
/// [material] Whether the material, or one that it mixes, uses a filtered image.
[[nodiscard]] std::vector<std::uint8_t> materials_with_filtered_images(const SceneDescription& scene);

/// Whether the shape has no surface: pbrt's "interface", or a material without a type.
[[nodiscard]] bool is_interface(const SceneDescription& scene, const SceneShape& shape);
[[nodiscard]] bool is_interface(const SceneEntity& material);
/// [material] Whether it is a mix, possibly of mixes, with an interface among its parts.
[[nodiscard]] std::vector<std::uint8_t> mixes_with_interface(const SceneDescription& scene);

}  // namespace raylex::transport
