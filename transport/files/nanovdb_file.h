// Grids of NanoVDB files (K. Museth 2021, "NanoVDB: A GPU-Friendly and Portable VDB Data Structure"). The library's own
// headers read them after raylex has checked that no offset in them leaves the file.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lpe/result.h"
#include "transport/math/matrix34.h"
#include "transport/math/voxel_grid.h"

namespace raylex::transport {

struct NanoVdbGrid {
    VoxelGrid values;
    std::array<int, 3> origin{};  ///< index-space coordinates of the first point of cell (0, 0, 0)
    DVec3 lower, upper;  ///< index space: the box of active voxels; each reaches to the coordinates of the next
    Matrix4 world_from_index{};
    BadValues bad;
};

/// Reads the grid called `name` of the file at `path`; returns nothing if the file has no such grid. Errors name the
/// file: damage, another version, a grid that does not contain numbers, budgets.
Result<std::optional<NanoVdbGrid>> read_nanovdb_grid(const std::string& path, const std::string& name,
                                                     bool may_be_negative);

/// The names of all grids in a file, in its order. Errors are those of read_nanovdb_grid().
Result<std::vector<std::string>> nanovdb_grid_names(const std::string& path);

}  // namespace raylex::transport
