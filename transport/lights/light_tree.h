// Chooses one of very many lights by what each may send to a point: a binary tree of lights, descended at random in
// proportion to the expected contribution of either half. The tree is that of Conty Estevez and Kulla 2018 (without its
// splitting, like pbrt-v4's BVHLightSampler); light_bounds.h computes the expected contribution. The time of a choice
// depends on the tree's depth alone.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "transport/lights/light_bounds.h"

namespace raylex::transport {

class LightTree {
  public:
    LightTree() = default;
    /// A tree over the lights `wanted` (indices), which have positions and positive power.
    LightTree(std::span<const Light> lights, const EmbreeScene& geometry, std::vector<std::uint32_t> wanted);

    static constexpr std::uint32_t none = 0xffffffffu;
    struct Chosen {
        std::uint32_t light = none;  ///< none: no light of the tree sends anything there
        Real probability = 0;
    };
    /// Chooses a light. `u` in [0, 1) needs more than float's precision: a choice uses log2 of the number of lights of
    /// its bits.
    [[nodiscard]] Chosen choose(const LightReceiver& receiver, double u) const;
    /// The probability with which choose() returns the light; 0 for lights outside the tree.
    [[nodiscard]] Real probability(const LightReceiver& receiver, std::uint32_t light) const;
    [[nodiscard]] bool empty() const { return nodes_.empty(); }

  private:
    /// A cache line (in float); a choice reads two nodes at each depth, which are adjacent.
    struct alignas(64) Node {
        LightMoments moments;
        std::uint32_t children : 31 = 0;  ///< index of the first child; the second follows; 0: a leaf
        std::uint32_t has_cone : 1 = 0;   ///< the node's lights do not reach all points: see cones_
        std::uint32_t light = none;
    };
    struct Cone {
        EmissionCone emission;
        Real radius2 = 0;  ///< of a ball around the mean of the moments
    };
    struct Item {
        std::uint32_t light;
        LightBounds bounds;
        LightMoments moments;
        Vec3 center;
    };
    /// Builds node `at` from these items, and the nodes below.
    void build(std::uint32_t at, std::span<Item> items, std::uint64_t trail, int depth);
    static std::size_t split(std::span<Item> items, const LightBounds& whole);
    /// 0 only if no light arrives.
    [[nodiscard]] double importance(std::uint32_t at, const LightReceiver& receiver) const {
        const Node& node = nodes_[at];
        if (node.has_cone != 0) {
            const Cone& cone = cones_[at];
            if (!cone.emission.reaches(receiver.position - node.moments.mean, cone.radius2)) return 0;
        }
        return node.moments.importance(receiver);
    }

    std::vector<Node> nodes_;
    std::vector<Cone> cones_;            // [node]
    std::vector<std::uint64_t> trails_;  // [light] which child at each depth, from the lowest bit up
    std::vector<std::uint8_t> within_;   // [light]
};

}  // namespace raylex::transport
