// Choosing one of very many lights by what each may send to a point: a binary tree over their bounds, gone down by
// chance in proportion to what either half may contribute (Conty Estevez and Kulla 2018, without its splitting, as
// pbrt-v4's BVHLightSampler). The time of a choice grows with the tree's depth alone.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "transport/lights/light_bounds.h"

namespace raylex::transport {

class LightTree {
  public:
    LightTree() = default;
    /// Over lights that stand somewhere, `wanted` (their numbers), each of some power.
    LightTree(std::span<const Light> lights, const EmbreeScene& geometry, std::vector<std::uint32_t> wanted);

    static constexpr std::uint32_t none = 0xffffffffu;
    struct Chosen {
        std::uint32_t light = none;  ///< none: no light of the tree sends anything there
        Real probability = 0;
    };
    /// `u` in [0, 1), of more than float's precision: a choice takes log2 of the number of lights of its bits.
    [[nodiscard]] Chosen choose(const LightReceiver& receiver, double u) const;
    /// With which choose() gives the light; 0 for lights that are not in the tree.
    [[nodiscard]] Real probability(const LightReceiver& receiver, std::uint32_t light) const;
    [[nodiscard]] bool empty() const { return nodes_.empty(); }

  private:
    struct Node {
        LightBounds bounds;
        std::uint32_t second = 0;  ///< number of the second child, the first follows its parent; 0: a leaf
        std::uint32_t light = none;
    };
    struct Item {
        std::uint32_t light;
        LightBounds bounds;
        Vec3 center;
    };
    std::uint32_t build(std::span<Item> items, std::uint64_t trail, int depth);
    static std::size_t split(std::span<Item> items, const LightBounds& whole);

    std::vector<Node> nodes_;
    std::vector<std::uint64_t> trails_;  // [light] which child at each depth, from the lowest bit up
    std::vector<std::uint8_t> within_;   // [light]
};

}  // namespace raylex::transport
