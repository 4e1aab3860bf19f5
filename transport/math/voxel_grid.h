// Values on a lattice with linear interpolation: the densities, temperatures and colours of media.
//
// The lattice is divided into cells of 4^3 steps, or 8^3 for large lattices. A cell with varying values stores its
// points contiguously, those on its faces twice, so that a look-up reads one stretch of memory and has bounds on the
// result. A cell with a constant value, such as empty space, stores only that value.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "transport/math/vec.h"

namespace raylex::transport {

/// The extent of a lattice in cells, and the indices of cells.
struct CellBox {
    std::array<int, 3> size{1, 1, 1};
    int side = 4;  ///< steps of the lattice along one side of a cell

    /// A box that contains this many steps: with cells of 4 steps if their number is acceptable for traversal and
    /// memory, else of 8.
    static CellBox holding(const std::array<int, 3>& steps) {
        constexpr std::size_t many = std::size_t{1} << 21;
        CellBox box;
        for (box.side = 4;; box.side = 8) {
            for (std::size_t a = 0; a < 3; ++a) box.size[a] = (steps[a] - 1) / box.side + 1;
            if (box.count() <= many || box.side == 8) return box;
        }
    }
    [[nodiscard]] int points() const { return (side + 1) * (side + 1) * (side + 1); }

    /// The number of cells, at most 2^60, which exceeds any memory, however large the sides in a file are.
    [[nodiscard]] std::size_t count() const {
        constexpr std::size_t most = std::size_t{1} << 60;
        const std::size_t area = static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]);
        const auto depth = static_cast<std::size_t>(size[2]);
        return area > most / depth ? most : area * depth;
    }
    [[nodiscard]] std::size_t index(int x, int y, int z) const {
        return static_cast<std::size_t>(x) +
               static_cast<std::size_t>(size[0]) *
                   (static_cast<std::size_t>(y) + static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(z));
    }
};

/// The least and the largest value in a cell, over all channels.
struct CellBounds {
    float least = 0, most = 0;
};

class VoxelGrid {
  public:
    /// Writes all points of cell (x, y, z): those of the lattice from side (x, y, z) to side (x + 1, y + 1, z + 1),
    /// ends included, x fastest, with the channels of a point adjacent. Called for all cells, for some twice, by
    /// several threads. Values must be finite.
    using Fill = std::function<void(int x, int y, int z, float* values)>;
    /// Returns the constant value of a cell and its faces in all channels, or NaN if Fill has to compute it. Empty:
    /// Fill computes all cells.
    using Constant = std::function<float(int x, int y, int z)>;
    static VoxelGrid build(const CellBox& cells, int channels, const Fill& fill, const Constant& constant = {});
    /// Helper for a Fill: calls `visit(x, y, z)` with all points of a cell.
    template <class Visit>
    static void for_each_point(int side, int cell_x, int cell_y, int cell_z, const Visit& visit) {
        for (int z = 0; z <= side; ++z)
            for (int y = 0; y <= side; ++y)
                for (int x = 0; x <= side; ++x) visit(cell_x * side + x, cell_y * side + y, cell_z * side + z);
    }

    [[nodiscard]] bool empty() const { return cells_.empty(); }
    [[nodiscard]] const CellBox& box() const { return box_; }
    [[nodiscard]] CellBounds bounds(std::size_t cell) const { return cells_[cell].bounds; }
    [[nodiscard]] std::size_t bytes() const { return cells_.size() * sizeof(Cell) + values_.size() * sizeof(float); }

    /// The value at `where` in [0, 1]^3 of a cell.
    [[nodiscard]] Real real(std::size_t cell, const Vec3& where) const {
        const Cell& c = cells_[cell];
        if (c.values < 0) return static_cast<Real>(c.bounds.least);
        return interpolate<1>(c, where, 0);
    }
    /// The value at `where` in [0, 1]^3 of a cell of a grid with three channels.
    [[nodiscard]] Rgb rgb(std::size_t cell, const Vec3& where) const {
        const Cell& c = cells_[cell];
        if (c.values < 0) return Rgb(static_cast<Real>(c.bounds.least));
        return {interpolate<3>(c, where, 0), interpolate<3>(c, where, 1), interpolate<3>(c, where, 2)};
    }

  private:
    struct Cell {
        CellBounds bounds;
        std::int32_t values = -1;  // index of the block in values_; -1: a constant value in all channels
    };
    template <int channels>
    [[nodiscard]] Real interpolate(const Cell& cell, const Vec3& where, int channel) const {
        const int side = box_.side, row = side + 1;
        const auto split = [side](Real x, int& whole) {
            const Real scaled = x * static_cast<Real>(side);
            whole = std::clamp(static_cast<int>(scaled), 0, side - 1);
            return scaled - static_cast<Real>(whole);
        };
        int x = 0, y = 0, z = 0;
        const Real fx = split(where.x, x), fy = split(where.y, y), fz = split(where.z, z);
        const float* v = values_.data() +
                         static_cast<std::size_t>(cell.values) * static_cast<std::size_t>(box_.points() * channels) +
                         (x + row * (y + row * z)) * channels + channel;
        const auto along_x = [&](int offset) {
            const auto a = static_cast<Real>(v[offset]), b = static_cast<Real>(v[offset + channels]);
            return a + fx * (b - a);
        };
        const auto in_plane = [&](int offset) {
            const Real a = along_x(offset), b = along_x(offset + row * channels);
            return a + fy * (b - a);
        };
        const Real a = in_plane(0), b = in_plane(row * row * channels);
        return a + fz * (b - a);
    }

    CellBox box_;
    std::vector<Cell> cells_;
    std::vector<float> values_;
};

/// Counts invalid values: NaN, infinity, and negative values where they are not allowed. They are replaced by 0, with a
/// warning.
struct BadValues {
    std::size_t count = 0;
    std::array<int, 3> first{};  ///< the position of the first invalid value

    /// Returns `value`, or 0 if it is invalid.
    float checked(float value, bool may_be_negative, int x, int y, int z) {
        if (std::isfinite(value) && (may_be_negative || value >= 0)) return value;
        if (count++ == 0) first = {x, y, z};
        return 0;
    }
};

}  // namespace raylex::transport
