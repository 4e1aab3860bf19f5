#include "transport/import/nanovdb_file.h"

#include <nanovdb/util/GridHandle.h>
#include <nanovdb/util/IO.h>

#include <cstring>
#include <exception>
#include <filesystem>

#include "lpe/budgets.h"

namespace raylex::transport {
namespace {

using Handle = nanovdb::GridHandle<nanovdb::HostBuffer>;
using MetaData = nanovdb::io::GridMetaData;

Error damaged(const std::string& path, const std::string& what) {
    return Error{"the NanoVDB file is damaged: " + what, path, 0, 0, {}, {}};
}

/// The library says what is wrong by exceptions, lack of memory included.
template <class Call>
auto guarded(const std::string& path, const Call& call) -> Result<decltype(call())> {
    try {
        return call();
    } catch (const std::bad_alloc&) {
        return damaged(path, "it asks for more memory than there is");
    } catch (const std::exception& failure) {
        return Error{std::string("not a readable NanoVDB file: ") + failure.what(), path, 0, 0, {}, {}};
    }
}

Result<std::vector<MetaData>> read_meta_data(const std::string& path) {
    std::error_code failed;
    const std::uint64_t size = std::filesystem::file_size(path, failed);
    if (failed || !std::filesystem::is_regular_file(path, failed))
        return Error{"expected a NanoVDB file; found no regular file", path, 0, 0, {}, {}};
    if (size > budget(Budget::file_bytes))
        return over_budget(Budget::file_bytes, "the NanoVDB file has " + std::to_string(size) + " bytes", path);
    Result<std::vector<MetaData>> grids = guarded(path, [&] { return nanovdb::io::readGridMetaData(path); });
    if (!grids) return grids;
    for (const MetaData& grid : *grids) {
        const bool packed = grid.codec != nanovdb::io::Codec::NONE;
        const std::uint64_t most =
            packed ? std::max(size * budget(Budget::unpack_ratio), budget(Budget::unpack_floor)) : size;
        if (grid.gridSize > most)
            return packed ? over_budget(
                                Budget::unpack_ratio,
                                "grid '" + grid.gridName + "' unpacks to " + std::to_string(grid.gridSize) + " bytes",
                                path)
                          : damaged(path, "grid '" + grid.gridName + "' is larger than the file");
    }
    return grids;
}

/// What a grid's tree holds: checked to lie within the buffer, node by node, before anything looks a value up.
template <class Build>
class TreeReader {
  public:
    using Grid = nanovdb::NanoGrid<Build>;
    using Root = typename Grid::TreeType::RootType;
    using Upper = typename Root::ChildNodeType;
    using Lower = typename Upper::ChildNodeType;
    using Leaf = typename Lower::ChildNodeType;

    TreeReader(const Handle& handle, const std::string& path, bool may_be_negative)
        : begin_(handle.data()), size_(handle.size()), path_(path), may_be_negative_(may_be_negative) {}

    Result<NanoVdbGrid> read();

  private:
    [[nodiscard]] bool holds(const void* at, std::uint64_t bytes) const {
        const auto address = reinterpret_cast<std::uintptr_t>(at), begin = reinterpret_cast<std::uintptr_t>(begin_);
        return address >= begin && address % 8 == 0 && address - begin <= size_ && bytes <= size_ - (address - begin);
    }
    Status read_box(const Root& root);
    Status visit(const Root& root);
    Status visit(const Upper& node, const nanovdb::Coord& origin);
    Status visit(const Lower& node, const nanovdb::Coord& origin);
    Status visit(const Leaf& leaf, const nanovdb::Coord& origin);
    /// Cells that a cube of values touches.
    void mark(const nanovdb::Coord& origin, int edge);
    float checked(float value, const nanovdb::Coord& at) {
        return result_.bad.checked(value, may_be_negative_, at[0], at[1], at[2]);
    }

    const std::uint8_t* begin_;
    std::uint64_t size_;
    const std::string& path_;
    bool may_be_negative_;
    NanoVdbGrid result_;
    CellBox cells_;
    std::vector<std::uint8_t> occupied_;
};

template <class Build>
Result<NanoVdbGrid> TreeReader<Build>::read() {
    const auto* grid = reinterpret_cast<const Grid*>(begin_);
    const Root& root = grid->tree().root();
    if (!holds(&root, sizeof(Root)) ||
        !holds(&root, sizeof(Root) + root.data()->mTableSize * std::uint64_t{sizeof(typename Root::Tile)}))
        return damaged(path_, "its tree lies outside of the grid");
    const nanovdb::Vec3d zero = grid->map().applyMap(nanovdb::Vec3d(0, 0, 0));
    for (int c = 0; c < 3; ++c) {
        const nanovdb::Vec3d unit(c == 0 ? 1 : 0, c == 1 ? 1 : 0, c == 2 ? 1 : 0);
        const nanovdb::Vec3d image = grid->map().applyMap(unit);
        for (int r = 0; r < 3; ++r) {
            result_.world_from_index[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)] = image[r] - zero[r];
            result_.world_from_index[static_cast<std::size_t>(r)][3] = zero[r];
        }
    }
    result_.world_from_index[3] = {0, 0, 0, 1};
    const Transform map(result_.world_from_index);
    if (!map.invertible()) return damaged(path_, "its map from voxels to the world cannot be inverted");
    if (Status s = read_box(root); !s) return s.error();
    if (Status s = visit(root); !s) return s.error();
    const std::array<int, 3>& first = result_.origin;
    const auto fill = [&](int cell_x, int cell_y, int cell_z, float* to) {
        auto accessor = grid->getAccessor();
        BadValues passed_over;  // counted leaf by leaf
        VoxelGrid::for_each_point(cells_.side, cell_x, cell_y, cell_z, [&](int x, int y, int z) {
            const auto value = static_cast<float>(accessor.getValue({first[0] + x, first[1] + y, first[2] + z}));
            *to++ = passed_over.checked(value, may_be_negative_, x, y, z);
        });
    };
    result_.values =
        VoxelGrid::build(cells_, 1, fill, [&](int x, int y, int z) { return occupied_[cells_.index(x, y, z)] != 0; });
    return std::move(result_);
}

template <class Build>
Status TreeReader<Build>::read_box(const Root& root) {
    const auto& box = root.bbox();
    constexpr int farthest = 1 << 29;
    std::array<int, 3> steps{};
    std::array<double, 3> lower{}, upper{};
    for (int a = 0; a < 3; ++a) {
        const int least = box.min()[a], most = box.max()[a];
        const auto i = static_cast<std::size_t>(a);
        if (least > most) return Error{"the grid has no active voxel", path_, 0, 0, {}, {}};
        if (least < -farthest || most > farthest) return damaged(path_, "its box of voxels has no bounds");
        // Zeros stand around the box, and leaves begin at multiples of 8: so do cells.
        result_.origin[i] = (least - 1) & ~7;
        steps[i] = most + 1 - result_.origin[i];
        lower[i] = least;
        upper[i] = most + 1;
    }
    result_.lower = {lower[0], lower[1], lower[2]};
    result_.upper = {upper[0], upper[1], upper[2]};
    cells_ = CellBox::holding(steps);
    if (cells_.count() > budget(Budget::volume_cells))
        return over_budget(Budget::volume_cells,
                           "the box of the grid's voxels has " + std::to_string(cells_.count()) + " cells", path_);
    occupied_.assign(cells_.count(), 0);
    return success();
}

template <class Build>
void TreeReader<Build>::mark(const nanovdb::Coord& origin, int edge) {
    std::array<int, 3> first{}, last{};
    const int shift = cells_.side == 4 ? 2 : 3;
    for (int a = 0; a < 3; ++a) {
        const auto i = static_cast<std::size_t>(a);
        // A point on a border belongs to the cell before, too. Shifts round down.
        const std::int64_t from = std::int64_t{origin[a]} - result_.origin[i];
        first[i] = static_cast<int>(std::clamp<std::int64_t>((from - 1) >> shift, 0, cells_.size[i]));
        last[i] = static_cast<int>(std::clamp<std::int64_t>((from + edge - 1) >> shift, -1, cells_.size[i] - 1));
    }
    for (int z = first[2]; z <= last[2]; ++z)
        for (int y = first[1]; y <= last[1]; ++y)
            for (int x = first[0]; x <= last[0]; ++x) occupied_[cells_.index(x, y, z)] = 1;
}

template <class Build>
Status TreeReader<Build>::visit(const Root& root) {
    if (const auto background = static_cast<float>(root.background()); background != 0)
        std::fill(occupied_.begin(), occupied_.end(), std::uint8_t{1});
    constexpr int edge = 4096;
    for (std::uint32_t n = 0; n < root.data()->mTableSize; ++n) {
        const auto* tile = root.data()->tile(n);
        if (!tile->isChild()) {
            if (checked(static_cast<float>(tile->value), tile->origin()) != 0) mark(tile->origin(), edge);
            continue;
        }
        const Upper& child = *root.data()->getChild(tile);
        if (!holds(&child, sizeof(Upper))) return damaged(path_, "an upper node lies outside of the grid");
        if (Status s = visit(child, tile->origin()); !s) return s;
    }
    return success();
}

template <class Build>
Status TreeReader<Build>::visit(const Upper& node, const nanovdb::Coord& origin) {
    for (std::uint32_t n = 0; n < Upper::SIZE; ++n) {
        const nanovdb::Coord at = origin + (Upper::OffsetToLocalCoord(n) << Lower::TOTAL);
        if (node.data()->mChildMask.isOn(n)) {
            const Lower& child = *node.data()->getChild(n);
            if (!holds(&child, sizeof(Lower))) return damaged(path_, "a lower node lies outside of the grid");
            if (Status s = visit(child, at); !s) return s;
        } else if (checked(static_cast<float>(node.data()->getValue(n)), at) != 0) {
            mark(at, 1 << Lower::TOTAL);
        }
    }
    return success();
}

template <class Build>
Status TreeReader<Build>::visit(const Lower& node, const nanovdb::Coord& origin) {
    for (std::uint32_t n = 0; n < Lower::SIZE; ++n) {
        const nanovdb::Coord at = origin + (Lower::OffsetToLocalCoord(n) << Leaf::TOTAL);
        if (node.data()->mChildMask.isOn(n)) {
            const Leaf& child = *node.data()->getChild(n);
            if (!holds(&child, sizeof(Leaf))) return damaged(path_, "a leaf lies outside of the grid");
            if (Status s = visit(child, at); !s) return s;
        } else if (checked(static_cast<float>(node.data()->getValue(n)), at) != 0) {
            mark(at, 1 << Leaf::TOTAL);
        }
    }
    return success();
}

template <class Build>
Status TreeReader<Build>::visit(const Leaf& leaf, const nanovdb::Coord& origin) {
    if constexpr (std::is_same_v<Build, nanovdb::FpN>)
        if (!holds(&leaf, leaf.data()->memUsage())) return damaged(path_, "a leaf lies outside of the grid");
    bool any = false;
    for (std::uint32_t n = 0; n < Leaf::SIZE; ++n) {
        const float value = checked(static_cast<float>(leaf.getValue(n)), origin + Leaf::OffsetToLocalCoord(n));
        any = any || value != 0;
    }
    if (any) mark(origin, 1 << Leaf::TOTAL);
    return success();
}

Result<NanoVdbGrid> read_tree(const Handle& handle, const std::string& path, bool may_be_negative) {
    switch (handle.gridType()) {
        case nanovdb::GridType::Float:
            return TreeReader<float>(handle, path, may_be_negative).read();
        case nanovdb::GridType::Double:
            return TreeReader<double>(handle, path, may_be_negative).read();
        case nanovdb::GridType::Fp4:
            return TreeReader<nanovdb::Fp4>(handle, path, may_be_negative).read();
        case nanovdb::GridType::Fp8:
            return TreeReader<nanovdb::Fp8>(handle, path, may_be_negative).read();
        case nanovdb::GridType::Fp16:
            return TreeReader<nanovdb::Fp16>(handle, path, may_be_negative).read();
        case nanovdb::GridType::FpN:
            return TreeReader<nanovdb::FpN>(handle, path, may_be_negative).read();
        default:
            break;
    }
    const char* type = nanovdb::toStr(handle.gridType());
    return Error{std::string("the grid is of type ") + (type != nullptr ? type : "unknown") +
                     "; expected numbers: float, double, Fp4, Fp8, Fp16 or FpN",
                 path,
                 0,
                 0,
                 {},
                 {}};
}

}  // namespace

Result<std::vector<std::string>> nanovdb_grid_names(const std::string& path) {
    const Result<std::vector<MetaData>> grids = read_meta_data(path);
    if (!grids) return grids.error();
    std::vector<std::string> names;
    for (const MetaData& grid : *grids) names.push_back(grid.gridName);
    return names;
}

Result<std::optional<NanoVdbGrid>> read_nanovdb_grid(const std::string& path, const std::string& name,
                                                     bool may_be_negative) {
    const Result<std::vector<MetaData>> grids = read_meta_data(path);
    if (!grids) return grids.error();
    const auto named = [&](const MetaData& each) { return each.gridName == name; };
    if (std::none_of(grids->begin(), grids->end(), named)) return std::optional<NanoVdbGrid>();
    const Result<Handle> handle = guarded(path, [&] { return nanovdb::io::readGrid(path, name); });
    if (!handle) return handle.error();
    const std::uint64_t size = handle->size();
    if (size < sizeof(nanovdb::GridData) + sizeof(nanovdb::NanoTree<float>))
        return damaged(path, "grid '" + name + "' is too small to be one");
    const auto& data = *reinterpret_cast<const nanovdb::GridData*>(handle->data());
    if (data.mMagic != NANOVDB_MAGIC_NUMBER || data.mGridSize > size)
        return damaged(path, "grid '" + name + "' ends early or does not begin as one");
    Result<NanoVdbGrid> read = read_tree(*handle, path, may_be_negative);
    if (!read) return read.error();
    return std::optional(*std::move(read));
}

}  // namespace raylex::transport
