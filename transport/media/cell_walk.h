// Traverses the cells of a box along a ray (J. Amanatides and A. Woo 1987, "A Fast Voxel Traversal Algorithm for Ray
// Tracing", Eurographics).
#pragma once

#include <algorithm>
#include <cmath>

#include "transport/geometry/ray.h"
#include "transport/math/matrix34.h"
#include "transport/math/voxel_grid.h"

namespace raylex::transport {

/// A segment through a medium: `direction` is unit, `end` is the distance of its end, or infinity. Render space.
struct MediumSegment {
    Vec3 origin, direction;
    Real end = infinity;
};

/// The placement of a box of cells. Cell (i, j, k) is [i, i + 1] x [j, j + 1] x [k, k + 1] of the box's own space.
struct CellFrame {
    Matrix34 to_cells;   ///< from render space
    DVec3 lower, upper;  ///< the non-empty part of the box, in its own space
    CellBox box;
};

class CellWalk {
  public:
    CellWalk(const CellFrame& frame, const MediumSegment& segment);

    /// Whether the walk is at a cell.
    [[nodiscard]] bool inside() const { return inside_; }
    [[nodiscard]] std::size_t cell() const { return index_; }
    /// The beginning of the ray's part in the cell; distances count from the ray's entry into the box.
    [[nodiscard]] Real begin() const { return begin_; }
    [[nodiscard]] Real end() const { return end_; }
    /// The distance `t` counted from the segment's origin.
    [[nodiscard]] Real distance(Real t) const { return start_ + t; }
    /// The point at `t`, in [0, 1]^3 of the cell: never outside, despite rounding.
    [[nodiscard]] Vec3 local(Real t) const {
        const auto along = [&](std::size_t a) {
            return std::clamp(entry_[a] + way_[a] * t - static_cast<Real>(cell_[a]), Real(0), Real(1));
        };
        return {along(0), along(1), along(2)};
    }
    /// The point at `t` in the box's own space.
    [[nodiscard]] Vec3 in_box(Real t) const {
        return local(t) + Vec3{static_cast<Real>(cell_[0]), static_cast<Real>(cell_[1]), static_cast<Real>(cell_[2])};
    }
    /// The number of cells per unit of distance.
    [[nodiscard]] Real cells_per_distance() const {
        return std::sqrt(way_[0] * way_[0] + way_[1] * way_[1] + way_[2] * way_[2]);
    }

    void next() {
        const std::size_t a = next_[0] < next_[1] ? (next_[0] < next_[2] ? 0 : 2) : (next_[1] < next_[2] ? 1 : 2);
        begin_ = end_;
        cell_[a] += step_[a];
        if (cell_[a] < 0 || cell_[a] >= size_[a] || !(begin_ < length_)) {
            inside_ = false;
            return;
        }
        index_ += stride_[a];
        next_[a] = border(a);
        set_end();
    }

  private:
    /// The distance at which the ray leaves the cell along an axis.
    [[nodiscard]] Real border(std::size_t a) const {
        if (step_[a] == 0) return infinity;
        return (static_cast<Real>(cell_[a] + (step_[a] > 0 ? 1 : 0)) - entry_[a]) * inverse_[a];
    }
    void set_end() { end_ = std::max(begin_, std::min({next_[0], next_[1], next_[2], length_})); }

    std::array<Real, 3> entry_{}, way_{}, inverse_{};  // way_: cells per unit of distance
    std::array<int, 3> cell_{}, step_{}, size_{};
    std::array<std::size_t, 3> stride_{};  // of index_, per step; wraps around for steps down
    std::array<Real, 3> next_{};           // where the ray leaves the cell along each axis
    std::size_t index_ = 0;
    Real start_ = 0, length_ = 0, begin_ = 0, end_ = 0;
    bool inside_ = false;
};

/// In double, since a ray may come from far away.
inline CellWalk::CellWalk(const CellFrame& frame, const MediumSegment& segment) {
    const DVec3 o = frame.to_cells.point(DVec3(segment.origin)), d = frame.to_cells.vector(DVec3(segment.direction));
    const std::array<double, 3> from{o.x, o.y, o.z}, way{d.x, d.y, d.z};
    const std::array<double, 3> lower{frame.lower.x, frame.lower.y, frame.lower.z},
        upper{frame.upper.x, frame.upper.y, frame.upper.z};
    double first = 0, last = static_cast<double>(segment.end);
    for (std::size_t a = 0; a < 3; ++a) {
        if (way[a] == 0) {
            if (!(from[a] >= lower[a] && from[a] <= upper[a])) return;
            continue;
        }
        const double one = (lower[a] - from[a]) / way[a], other = (upper[a] - from[a]) / way[a];
        first = std::max(first, std::min(one, other));
        last = std::min(last, std::max(one, other));
    }
    if (!(first < last)) return;
    inside_ = true;
    start_ = static_cast<Real>(first);
    length_ = static_cast<Real>(last - first);
    size_ = frame.box.size;
    const std::array<std::size_t, 3> strides{1, static_cast<std::size_t>(size_[0]),
                                             static_cast<std::size_t>(size_[0]) * static_cast<std::size_t>(size_[1])};
    for (std::size_t a = 0; a < 3; ++a) {
        entry_[a] = static_cast<Real>(from[a] + way[a] * first);
        way_[a] = static_cast<Real>(way[a]);
        inverse_[a] = 1 / way_[a];
        step_[a] = way_[a] > 0 ? 1 : way_[a] < 0 ? -1 : 0;
        stride_[a] = step_[a] < 0 ? std::size_t{0} - strides[a] : strides[a];
        cell_[a] = std::clamp(static_cast<int>(std::floor(entry_[a])), 0, size_[a] - 1);
        next_[a] = border(a);
    }
    index_ = frame.box.index(cell_[0], cell_[1], cell_[2]);
    set_end();
}

}  // namespace raylex::transport
