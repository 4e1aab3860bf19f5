#include "transport/paths/guide/guide_tree.h"

#include <algorithm>
#include <cmath>

#include "transport/math/octahedral.h"
#include "transport/math/sampling.h"

namespace raylex::transport {
namespace {

constexpr Real below_one = Real(1) - Real(0x1p-24);

std::uint32_t orientation_of(const Vec3& n) {
    const Real x = std::abs(n.x), y = std::abs(n.y), z = std::abs(n.z);
    const Real most = std::max({x, y, z});
    if (!(most > 0)) return GuideTree::orientations - 1;
    if (x == most) return n.x > 0 ? 0 : 1;
    if (y == most) return n.y > 0 ? 2 : 3;
    return n.z > 0 ? 4 : 5;
}

/// The half of [0, 1) that contains x: 0 or 1. x becomes the position within it.
std::uint32_t take_half(Real& x) {
    x *= 2;
    const std::uint32_t upper = x >= 1 ? 1 : 0;
    x -= static_cast<Real>(upper);
    return upper;
}

Vec2 square_of(const Vec3& direction) {
    const Vec2 at = octahedral_from_direction(direction);
    return {std::clamp(at.x, Real(0), below_one), std::clamp(at.y, Real(0), below_one)};
}

/// Draws one of two parts, the first with probability p, by u, which becomes the number within the part.
std::uint32_t choose_half(Real p, Real& u) {
    if (u < p) {
        u = std::min(u / p, below_one);
        return 0;
    }
    u = std::min((u - p) / (1 - p), below_one);
    return 1;
}

}  // namespace

GuideTree::GuideTree(const Bounds& box) : lower_(box.lower) {
    const auto inverse = [](Real width) { return width > 0 ? 1 / width : Real(0); };
    size_ = box.upper - box.lower;
    scale_ = {inverse(size_.x), inverse(size_.y), inverse(size_.z)};
    nodes_.resize(1 + orientations, Node{{1, 1, 1, 1}, {}});
    for (std::uint32_t i = 0; i < orientations; ++i) {
        space_.push_back({0, i});
        regions_.push_back({i + 1, 0});
    }
}

GuideTree::Place GuideTree::place_of(const Vec3& position, const Vec3& normal) const {
    const Vec3 at = position - lower_;
    std::array<Real, 3> x{at.x * scale_.x, at.y * scale_.y, at.z * scale_.z};
    // NaN, which no comparison holds for, becomes 0.
    for (Real& each : x) each = each > 0 ? std::min(each, below_one) : Real(0);
    Place place;
    const Space* node = &space_[orientation_of(normal)];
    for (std::uint32_t axis = 0; node->first != 0; axis = axis == 2 ? 0 : axis + 1, ++place.halvings)
        node = &space_[node->first + take_half(x[axis])];
    place.region = node->region;
    return place;
}

Vec3 GuideTree::extent(const Place& place) const {
    const auto along = [&](Real width, std::uint32_t axis) {
        return std::ldexp(width, -static_cast<int>((place.halvings + 2 - axis) / 3));
    };
    return {along(size_.x, 0), along(size_.y, 1), along(size_.z, 2)};
}

Vec3 GuideTree::sample(const Region& region, const Vec2& u) const {
    Real x = u.x, y = u.y, size = 1;
    Vec2 corner{0, 0};
    for (std::uint32_t number = region.root;;) {
        const Node& node = nodes_[number];
        const std::uint32_t column = choose_half((node.mass[0] + node.mass[2]) * Real(0.25), x);
        const std::uint32_t row = choose_half(node.mass[column] / (node.mass[column] + node.mass[column + 2]), y);
        size *= Real(0.5);
        corner.x += static_cast<Real>(column) * size;
        corner.y += static_cast<Real>(row) * size;
        number = node.child[2 * row + column];
        if (number == 0) break;
    }
    return direction_from_octahedral({corner.x + x * size, corner.y + y * size});
}

Real GuideTree::density(const Region& region, const Vec3& direction) const {
    Vec2 at = square_of(direction);
    Real density = uniform_sphere_pdf();
    for (std::uint32_t number = region.root; number != 0;) {
        const Node& node = nodes_[number];
        const std::uint32_t column = take_half(at.x), row = take_half(at.y);
        density *= node.mass[2 * row + column];
        if (!(density > 0)) return 0;
        number = node.child[2 * row + column];
    }
    return density;
}

std::size_t GuideTree::cell_of(const Region& region, const Vec3& direction) const {
    Vec2 at = square_of(direction);
    for (std::uint32_t number = region.root;;) {
        const std::uint32_t column = take_half(at.x), row = take_half(at.y), quadrant = 2 * row + column;
        if (nodes_[number].child[quadrant] == 0) return 4 * std::size_t{number} + quadrant;
        number = nodes_[number].child[quadrant];
    }
}

}  // namespace raylex::transport
