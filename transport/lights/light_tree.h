// Choosing one of very many lights by what each may send to a point: a binary tree over them, gone down by chance in
// proportion to what either half is expected to contribute. The tree is that of Conty Estevez and Kulla 2018 (without
// its splitting, as pbrt-v4's BVHLightSampler), what is expected that of light_bounds.h. The time of a choice grows
// with the tree's depth alone.
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
    /// A cache line (in float); a choice reads two at each depth, side by side.
    struct alignas(64) Node {
        LightMoments moments;
        std::uint32_t children : 31 = 0;  ///< number of the first, the second follows; 0: a leaf
        std::uint32_t has_cone : 1 = 0;   ///< there are points that its lights do not reach: see cones_
        std::uint32_t light = none;
    };
    struct Cone {
        EmissionCone emission;
        Real radius2 = 0;  ///< of a ball around the moments' mean
    };
    struct Item {
        std::uint32_t light;
        LightBounds bounds;
        LightMoments moments;
        Vec3 center;
    };
    /// Node `at`, over these, and what is below.
    void build(std::uint32_t at, std::span<Item> items, std::uint64_t trail, int depth);
    static std::size_t split(std::span<Item> items, const LightBounds& whole);
    /// 0 only where nothing arrives.
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
