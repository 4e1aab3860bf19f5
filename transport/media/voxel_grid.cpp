#include "transport/media/voxel_grid.h"

#include <tbb/parallel_for.h>

namespace raylex::transport {
namespace {

/// Reads the points of one cell; whether they all are the same.
struct CellReader {
    std::array<float, VoxelGrid::points * VoxelGrid::most_channels> values{};
    CellBounds bounds;
    bool flat = true;

    void read(const VoxelGrid::Fill& fill, int channels, int x, int y, int z) {
        fill(x, y, z, values.data());
        const auto n = static_cast<std::ptrdiff_t>(VoxelGrid::points) * channels;
        const auto [least, most] = std::minmax_element(values.begin(), values.begin() + n);
        bounds = {*least, *most};
        flat = *least == *most;
    }
};

}  // namespace

VoxelGrid VoxelGrid::build(const CellBox& cells, int channels, const Fill& fill, const Occupied& occupied) {
    VoxelGrid grid;
    grid.box_ = cells;
    grid.cells_.resize(cells.count());
    const auto for_each_cell = [&](const auto& visit) {
        tbb::parallel_for(0, cells.size[2], [&](int z) {
            for (int y = 0; y < cells.size[1]; ++y)
                for (int x = 0; x < cells.size[0]; ++x) visit(x, y, z, grid.cells_[cells.index(x, y, z)]);
        });
    };
    for_each_cell([&](int x, int y, int z, Cell& cell) {
        if (occupied && !occupied(x, y, z)) return;
        CellReader reader;
        reader.read(fill, channels, x, y, z);
        cell.bounds = reader.bounds;
        cell.values = reader.flat ? -1 : 0;
    });
    std::int32_t blocks = 0;
    for (Cell& cell : grid.cells_)
        if (cell.values == 0) cell.values = blocks++;
    const std::size_t block = static_cast<std::size_t>(points) * static_cast<std::size_t>(channels);
    grid.values_.resize(static_cast<std::size_t>(blocks) * block);
    for_each_cell([&](int x, int y, int z, Cell& cell) {
        if (cell.values < 0) return;
        CellReader reader;
        reader.read(fill, channels, x, y, z);
        std::copy_n(reader.values.begin(), block,
                    grid.values_.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(cell.values) * block));
    });
    return grid;
}

}  // namespace raylex::transport
