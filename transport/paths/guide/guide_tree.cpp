#include "transport/paths/guide/guide_tree.h"

#include <algorithm>
#include <cmath>

#include "transport/paths/guide/direction_square.h"

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

/// Coordinates as whole numbers of the smallest cells, which make each halving a shift.
struct Cell {
    explicit Cell(const Vec3& direction) {
        constexpr Real cells = std::uint32_t{1} << GuideTree::deepest_node;
        const Vec2 at = square_from_direction(direction);
        x = static_cast<std::uint32_t>(std::min(at.x, below_one) * cells);
        y = static_cast<std::uint32_t>(std::min(at.y, below_one) * cells);
    }
    [[nodiscard]] std::uint32_t quadrant(std::uint32_t depth) const {
        const std::uint32_t shift = GuideTree::deepest_node - 1 - depth;
        return 2 * (y >> shift & 1) + (x >> shift & 1);
    }
    std::uint32_t x, y;
};

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
    nodes_.resize(1 + orientations);
    for (std::uint32_t i = 0; i < orientations; ++i) {
        space_.push_back({0, i});
        regions_.push_back({i + 1, 0});
    }
}

GuideTree::Place GuideTree::place_of(const Vec3& position, const Vec3& normal) const {
    const Vec3 at = position - lower_;
    constexpr std::uint32_t bits = most_halvings / 3;
    std::array<std::uint32_t, 3> x{};
    for (int i = 0; i < 3; ++i) {
        const Real part = at[i] * scale_[i];
        // NaN, which no comparison holds for, becomes 0.
        x[static_cast<std::size_t>(i)] =
            part > 0 ? static_cast<std::uint32_t>(std::min(part, below_one) * Real{1u << bits}) : 0;
    }
    Place place;
    const Space* node = &space_[orientation_of(normal)];
    for (std::uint32_t shift = bits; node->first != 0;) {
        --shift;
        for (std::size_t axis = 0; axis < 3 && node->first != 0; ++axis, ++place.halvings)
            node = &space_[node->first + (x[axis] >> shift & 1)];
    }
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
        const Real left = node.share(0) + node.share(2);
        const std::uint32_t column = choose_half(left, x);
        const std::uint32_t row = choose_half(node.share(column) / (column == 0 ? left : 1 - left), y);
        size *= Real(0.5);
        corner.x += static_cast<Real>(column) * size;
        corner.y += static_cast<Real>(row) * size;
        number = node.child(2 * row + column);
        if (number == 0) break;
    }
    return direction_from_square({corner.x + x * size, corner.y + y * size});
}

Real GuideTree::density(const Region& region, const Vec3& direction) const {
    const Cell at(direction);
    Real density = square_per_steradian(direction);
    std::uint32_t number = region.root;
    for (std::uint32_t depth = 0; number != 0; ++depth) {
        const Node& node = nodes_[number];
        const std::uint32_t quadrant = at.quadrant(depth);
        density *= 4 * node.share(quadrant);
        number = node.child(quadrant);
    }
    return density;
}

std::vector<Real> GuideTree::shares_of_cells(const Region& region, std::uint32_t depth) const {
    std::vector<Real> shares;
    const std::uint32_t side = std::uint32_t{1} << depth;
    for (std::uint32_t y = 0; y < side; ++y)
        for (std::uint32_t x = 0; x < side; ++x) {
            Real share = 1;
            std::uint32_t number = region.root;
            for (std::uint32_t shift = depth; shift-- > 0;) {
                const std::uint32_t quadrant = 2 * (y >> shift & 1) + (x >> shift & 1);
                share *= number == 0 ? Real(0.25) : nodes_[number].share(quadrant);
                if (number != 0) number = nodes_[number].child(quadrant);
            }
            shares.push_back(share);
        }
    return shares;
}

std::vector<std::uint8_t> GuideTree::sides() const {
    std::vector<std::uint8_t> of_space(space_.size()), of_regions(regions_.size());
    for (std::size_t i = 0; i < space_.size(); ++i) {  // halves stand behind what they are halves of
        if (i < orientations) of_space[i] = static_cast<std::uint8_t>(i);
        const std::uint32_t first = space_[i].first;
        if (first == 0) of_regions[space_[i].region] = of_space[i];
        else of_space[first] = of_space[first + 1] = of_space[i];
    }
    return of_regions;
}

std::size_t GuideTree::cell_of(const Region& region, const Vec3& direction) const {
    const Cell at(direction);
    std::uint32_t number = region.root;
    for (std::uint32_t depth = 0;; ++depth) {
        const std::uint32_t quadrant = at.quadrant(depth), child = nodes_[number].child(quadrant);
        if (child == 0) return 4 * std::size_t{number} + quadrant;
        number = child;
    }
}

}  // namespace raylex::transport
