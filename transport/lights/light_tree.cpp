#include "transport/lights/light_tree.h"

#include <algorithm>
#include <array>

namespace raylex::transport {
namespace {

constexpr int most_depth = 62;  // bits of a trail

Real along(const Vec3& v, int axis) {
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

}  // namespace

LightTree::LightTree(std::span<const Light> lights, const EmbreeScene& geometry, std::vector<std::uint32_t> wanted) {
    double strongest = 0;
    for (const std::uint32_t light : wanted) strongest = std::max(strongest, lights[light].power);
    std::vector<Item> items;
    items.reserve(wanted.size());
    for (const std::uint32_t light : wanted) {
        // A light much weaker than the strongest, below the precision of float, still needs a positive power.
        const Real power = std::max(static_cast<Real>(lights[light].power / strongest), Real(1e-12));
        const LightBounds bounds = bounds_of(lights[light], geometry, power);
        items.push_back({light, bounds, moments_of(lights[light], bounds), (bounds.lower + bounds.upper) * Real(0.5)});
    }
    if (items.empty()) return;
    trails_.resize(lights.size());
    within_.resize(lights.size());
    nodes_.reserve(2 * items.size() - 1);
    cones_.reserve(2 * items.size() - 1);
    nodes_.emplace_back();
    cones_.emplace_back();
    build(0, items, 0, 0);
}

void LightTree::build(std::uint32_t at, std::span<Item> items, std::uint64_t trail, int depth) {
    LightBounds whole;
    if (items.size() == 1) {
        whole = items.front().bounds;
        nodes_[at].moments = items.front().moments;
        nodes_[at].light = items.front().light;
        trails_[nodes_[at].light] = trail;
        within_[nodes_[at].light] = 1;
    } else {
        for (const Item& item : items) whole = join(whole, item.bounds);
        // Halves the list if the lights are indistinguishable, or if a tree of lopsided splits would become too deep.
        const std::size_t middle = depth < most_depth / 2 ? split(items, whole) : items.size() / 2;
        const auto children = static_cast<std::uint32_t>(nodes_.size());
        nodes_.resize(nodes_.size() + 2);
        cones_.resize(nodes_.size());
        build(children, items.first(middle), trail, depth + 1);
        build(children + 1, items.subspan(middle), trail | std::uint64_t{1} << depth, depth + 1);
        nodes_[at].children = children & 0x7fffffffu;
        nodes_[at].moments = join(nodes_[children].moments, nodes_[children + 1].moments);
    }
    nodes_[at].has_cone = whole.cone.is_narrow() ? 1 : 0;
    cones_[at] = {whole.cone, whole.radius_squared(nodes_[at].moments.mean)};
}

/// Sorts into buckets along each axis and finds the border of least cost; returns the number of items before it.
std::size_t LightTree::split(std::span<Item> items, const LightBounds& whole) {
    constexpr int buckets = 12;
    Vec3 lower = items.front().center, upper = lower;
    for (const Item& item : items) {
        lower = smallest(lower, item.center);
        upper = largest(upper, item.center);
    }
    const auto bucket_of = [&](const Item& item, int axis) {
        const Real share = (along(item.center, axis) - along(lower, axis)) / (along(upper, axis) - along(lower, axis));
        return std::min(static_cast<int>(share * buckets), buckets - 1);
    };
    Real least = infinity;
    int best_axis = -1, best_border = 0;
    for (int axis = 0; axis < 3; ++axis) {
        if (!(along(upper, axis) > along(lower, axis))) continue;
        std::array<LightBounds, buckets> filled{};
        for (const Item& item : items) {
            LightBounds& bucket = filled[static_cast<std::size_t>(bucket_of(item, axis))];
            bucket = join(bucket, item.bounds);
        }
        for (int border = 1; border < buckets; ++border) {
            LightBounds below, above;
            for (int i = 0; i < buckets; ++i) {
                LightBounds& side = i < border ? below : above;
                side = join(side, filled[static_cast<std::size_t>(i)]);
            }
            if (!(below.power > 0) || !(above.power > 0)) continue;
            const Vec3 extent = whole.upper - whole.lower;
            const Real cost = below.cost(extent, axis) + above.cost(extent, axis);
            if (!(cost < least)) continue;
            least = cost;
            best_axis = axis;
            best_border = border;
        }
    }
    if (best_axis < 0) return items.size() / 2;
    const auto border = std::partition(items.begin(), items.end(),
                                       [&](const Item& item) { return bucket_of(item, best_axis) < best_border; });
    return static_cast<std::size_t>(border - items.begin());
}

LightTree::Chosen LightTree::choose(const LightReceiver& receiver, double u) const {
    Chosen chosen;
    double probability = 1;
    std::uint32_t at = 0;
    if (nodes_[0].children == 0 && !(importance(0, receiver) > 0)) return {};
    while (const std::uint32_t children = nodes_[at].children) {
        const double first = importance(children, receiver), second = importance(children + 1, receiver);
        if (!(first + second > 0)) return {};
        const double share = first / (first + second);
        if (u < share) {
            u /= share;
            probability *= share;
            at = children;
        } else {
            u = (u - share) / (1 - share);
            probability *= 1 - share;
            at = children + 1;
        }
        u = std::min(u, 1 - 0x1p-53);
    }
    chosen.light = nodes_[at].light;
    chosen.probability = static_cast<Real>(probability);
    return chosen;
}

Real LightTree::probability(const LightReceiver& receiver, std::uint32_t light) const {
    if (within_.empty() || within_[light] == 0) return 0;
    double probability = 1;
    std::uint64_t trail = trails_[light];
    if (nodes_[0].children == 0 && !(importance(0, receiver) > 0)) return 0;
    std::uint32_t at = 0;
    while (const std::uint32_t children = nodes_[at].children) {
        const double first = importance(children, receiver), second = importance(children + 1, receiver);
        if (!(first + second > 0)) return 0;
        const double share = first / (first + second);
        const auto side = static_cast<std::uint32_t>(trail & 1);
        probability *= side != 0 ? 1 - share : share;
        at = children + side;
        trail >>= 1;
    }
    return static_cast<Real>(probability);
}

}  // namespace raylex::transport
