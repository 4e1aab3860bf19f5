// The effects that a scene may use, and sets of them. transport/scene/effects/effects.h describes each.
#pragma once

#include <cstddef>
#include <cstdint>

namespace raylex::transport {

enum class Effect : std::uint8_t {
    media,
    depth_of_field,
    image_textures,
    alpha,
    shading_normals,
    bump,
    transmission,
    coats,
    facet_compensation,
    emissive_meshes,
    delta_lights,
    environment,
    instances,
    motion,
    texture_filtering,
    varying_media,
    dispersion
};
inline constexpr std::size_t effect_count = 17;

class EffectSet {
  public:
    void insert(Effect effect) { bits_ |= bit(effect); }
    [[nodiscard]] bool contains(Effect effect) const { return (bits_ & bit(effect)) != 0; }

  private:
    static constexpr std::uint32_t bit(Effect effect) { return 1u << static_cast<unsigned>(effect); }
    std::uint32_t bits_ = 0;
};

}  // namespace raylex::transport
