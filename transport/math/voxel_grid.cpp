#include "transport/math/voxel_grid.h"

#include <tbb/parallel_for.h>

#include <cmath>

namespace raylex::transport {
namespace {

/// Reads the points of one cell, and whether all are equal.
struct CellReader {
    std::vector<float> values;
    CellBounds bounds;
    bool flat = true;

    explicit CellReader(std::size_t count) : values(count) {}
    void read(const VoxelGrid::Fill& fill, int x, int y, int z) {
        fill(x, y, z, values.data());
        const auto [least, most] = std::minmax_element(values.begin(), values.end());
        bounds = {*least, *most};
        flat = *least == *most;
    }
};

}  // namespace

VoxelGrid VoxelGrid::build(const CellBox& cells, int channels, const Fill& fill, const Constant& constant) {
    VoxelGrid grid;
    grid.box_ = cells;
    grid.cells_.resize(cells.count());
    const auto block = static_cast<std::size_t>(cells.points() * channels);
    const auto for_each_cell = [&](const auto& visit) {
        tbb::parallel_for(0, cells.size[2], [&](int z) {
            for (int y = 0; y < cells.size[1]; ++y)
                for (int x = 0; x < cells.size[0]; ++x) visit(x, y, z, grid.cells_[cells.index(x, y, z)]);
        });
    };
    for_each_cell([&](int x, int y, int z, Cell& cell) {
        if (const float value = constant ? constant(x, y, z) : NAN; !std::isnan(value)) {
            cell.bounds = {value, value};
            return;
        }
        CellReader reader(block);
        reader.read(fill, x, y, z);
        cell.bounds = reader.bounds;
        cell.values = reader.flat ? -1 : 0;
    });
    std::int32_t blocks = 0;
    for (Cell& cell : grid.cells_)
        if (cell.values == 0) cell.values = blocks++;

    grid.values_.resize(static_cast<std::size_t>(blocks) * block);
    for_each_cell([&](int x, int y, int z, Cell& cell) {
        if (cell.values < 0) return;
        CellReader reader(block);
        reader.read(fill, x, y, z);
        std::copy_n(reader.values.begin(), block,
                    grid.values_.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(cell.values) * block));
    });
    return grid;
}

}  // namespace raylex::transport
