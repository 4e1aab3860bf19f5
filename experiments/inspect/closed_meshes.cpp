#include "experiments/inspect/closed_meshes.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "transport/math/matrix34.h"

namespace raylex::experiments {
namespace {

using transport::DVec3;
using transport::SceneShape;

/// Returns for each vertex the index of the first vertex at the same position.
std::vector<std::uint32_t> welded(const SceneShape& shape) {
    const auto key = [&](std::uint32_t i) {
        const auto& p = shape.positions[i];
        return std::array{p.x, p.y, p.z};
    };
    std::vector<std::uint32_t> order(shape.positions.size()), first(shape.positions.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
    for (std::size_t i = 0; i < order.size(); ++i)
        first[order[i]] = i > 0 && key(order[i]) == key(order[i - 1]) ? first[order[i - 1]] : order[i];
    return first;
}

/// Returns whether every edge has two faces, in any orientation.
bool is_closed(const SceneShape& shape) {
    const std::vector<std::uint32_t> vertex = welded(shape);
    std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
    edges.reserve(shape.indices.size());
    for (std::size_t face = 0; face + 3 <= shape.indices.size(); face += 3)
        for (std::size_t i = 0; i < 3; ++i) {
            const std::uint32_t a = vertex[shape.indices[face + i]], b = vertex[shape.indices[face + (i + 1) % 3]];
            if (a != b) edges.emplace_back(std::min(a, b), std::max(a, b));
        }
    std::sort(edges.begin(), edges.end());
    for (std::size_t i = 0; i < edges.size();) {
        std::size_t end = i;
        while (end < edges.size() && edges[end] == edges[i]) ++end;
        if (end - i != 2) return false;
        i = end;
    }
    return !edges.empty();
}

}  // namespace

std::optional<double> enclosed_volume(const SceneShape& shape) {
    if (shape.kind != transport::ShapeKind::triangle_mesh || shape.indices.empty() || !is_closed(shape)) return {};
    const DVec3 origin(shape.positions[shape.indices.front()]);
    double volume = 0;
    for (std::size_t face = 0; face + 3 <= shape.indices.size(); face += 3) {
        DVec3 p[3];
        for (std::size_t i = 0; i < 3; ++i) p[i] = DVec3(shape.positions[shape.indices[face + i]]) - origin;
        const DVec3 normal = cross(p[1] - p[0], p[2] - p[0]);
        const bool turned = !shape.normals.empty() && dot(normal, DVec3(shape.normals[shape.indices[face]])) < 0;
        volume += dot(p[0], normal) / 6 * (turned ? -1 : 1);
    }
    const bool reversed = shape.flip_normal != shape.object_to_world.swaps_handedness();
    return reversed ? -volume : volume;
}

}  // namespace raylex::experiments
