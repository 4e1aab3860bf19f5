// The clouds of pbrt-v4's "cloud" medium (its format): noise that thins out upwards, over a solid bottom.
#pragma once

#include "transport/math/vec.h"
#include "transport/math/voxel_grid.h"

namespace raylex::transport {

struct CloudDensity {
    Real density = 1, wispiness = 1, frequency = 5;
    Vec3 lower, cell{1, 1, 1};  ///< in the medium's own space: cell (i, j, k) of a box begins at lower + (i, j, k) cell

    /// The density in [0, 1] at a point of the medium's own space; y is up.
    [[nodiscard]] Real at(const Vec3& p) const;
    [[nodiscard]] Real in_box(const Vec3& p) const {
        return at(lower + Vec3{p.x * cell.x, p.y * cell.y, p.z * cell.z});
    }
    /// Bounds of at() in each cell. Noise has no useful exact bounds, so the maximum is that of 125 points in and
    /// around a cell, plus a margin. Tests count the points above it, which free flights clip.
    [[nodiscard]] std::vector<CellBounds> bounds(const CellBox& box) const;

  private:
    /// The density before it is clamped to [0, 1] and added to the bottom.
    [[nodiscard]] Real raised(const Vec3& p) const;
    static CellBox points_of(const CellBox& box);
    [[nodiscard]] std::vector<float> raised_at_points(const CellBox& box) const;
};

}  // namespace raylex::transport
