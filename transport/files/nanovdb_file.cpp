#include "transport/files/nanovdb_file.h"

#include <nanovdb/util/GridHandle.h>
#include <nanovdb/util/IO.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>

#include "lpe/input/budgets.h"

namespace raylex::transport {
namespace {

using Handle = nanovdb::GridHandle<nanovdb::HostBuffer>;
using MetaData = nanovdb::io::GridMetaData;

Error damaged(const std::string& path, const std::string& what) {
    return Error{"the NanoVDB file is damaged: " + what, path, 0, 0, {}, {}};
}

/// Converts the library's exceptions, including lack of memory, to errors.
template <class Call>
auto guarded(const std::string& path, const Call& call) -> Result<decltype(call())> {
    try {
        return call();
    } catch (const std::bad_alloc&) {
        return damaged(path, "it needs more memory than there is");
    } catch (const std::exception& failure) {
        return Error{std::string("not a readable NanoVDB file: ") + failure.what(), path, 0, 0, {}, {}};
    }
}

/// Checks packed data, where a size precedes each piece: the library allocates that size before it reads, and Blosc
/// reads as far as a header in the piece states.
Status check_packed(std::ifstream& file, nanovdb::io::Codec codec, const nanovdb::io::MetaData& grid, std::uint64_t at,
                    const std::string& path) {
    const std::uint64_t end = at + grid.fileSize;
    std::uint64_t left = grid.gridSize;
    do {
        std::uint64_t size = 0;
        file.seekg(static_cast<std::streamoff>(at));
        if (end - at < sizeof size || !file.read(reinterpret_cast<char*>(&size), sizeof size))
            return damaged(path, "a packed grid ends early");
        at += sizeof size;
        if (size > end - at) return damaged(path, "a piece of a packed grid is larger than the grid");
        at += size;
        if (codec != nanovdb::io::Codec::BLOSC) return success();
        std::array<std::uint32_t, 4> header{};  // kind, bytes unpacked, bytes of a block, bytes packed
        const std::uint64_t piece = std::min<std::uint64_t>(left, nanovdb::io::Internal::MAX_SIZE);
        if (size < sizeof header || !file.read(reinterpret_cast<char*>(&header), sizeof header) || header[1] != piece ||
            header[3] != size)
            return damaged(path, "a piece of a packed grid has another size than its header states");
        left -= piece;
    } while (left > 0);
    return success();
}

/// Checks the list of grids. The library assumes that names end with a zero and that listed grids exist; its error for
/// files of other versions leaks memory.
Status check_segments(const std::string& path, std::uint64_t size) {
    std::ifstream file(path, std::ios::binary);
    std::uint64_t at = 0;  // at most `size`: the bytes that have been read
    const auto take = [&](auto& record) {
        at += sizeof(record);
        return static_cast<bool>(file.read(reinterpret_cast<char*>(&record), sizeof(record)));
    };
    nanovdb::io::Header segment;
    while (take(segment) && segment.magic == NANOVDB_MAGIC_NUMBER) {  // the library reports any other beginning
        if (const std::uint32_t found = segment.version.getMajor(); found != NANOVDB_MAJOR_VERSION_NUMBER)
            return Error{"the file has NanoVDB version " + std::to_string(found) + "; expected version " +
                             std::to_string(NANOVDB_MAJOR_VERSION_NUMBER),
                         path,
                         0,
                         0,
                         {},
                         {}};
        std::uint64_t bytes = 0;
        std::vector<nanovdb::io::MetaData> grids;
        for (int i = 0; i < segment.gridCount; ++i) {
            nanovdb::io::MetaData& grid = grids.emplace_back();
            if (!take(grid)) return damaged(path, "it ends within its list of grids");
            if (grid.nameSize == 0 || grid.nameSize > size - at)
                return damaged(path, "a grid's name is longer than the file");
            at += grid.nameSize;
            if (file.seekg(grid.nameSize - 1, std::ios::cur); file.get() != 0)
                return damaged(path, "a grid's name does not end");
            if (grid.fileSize > size || bytes + grid.fileSize > size - at)
                return damaged(path, "a grid is larger than the file");
            bytes += grid.fileSize;
        }
        for (const nanovdb::io::MetaData& grid : grids) {
            if (segment.codec != nanovdb::io::Codec::NONE)  // the grids' own codecs are ignored
                if (Status s = check_packed(file, segment.codec, grid, at, path); !s) return s;
            at += grid.fileSize;
        }
        file.seekg(static_cast<std::streamoff>(at));
    }
    return success();
}

Result<std::vector<MetaData>> read_meta_data(const std::string& path) {
    std::error_code failed;
    const std::uint64_t size = std::filesystem::file_size(path, failed);
    if (failed || !std::filesystem::is_regular_file(path, failed))
        return Error{"expected a NanoVDB file; found no regular file", path, 0, 0, {}, {}};
    if (size > budget(Budget::file_bytes))
        return over_budget(Budget::file_bytes, "the NanoVDB file has " + std::to_string(size) + " bytes", path);
    if (Status s = check_segments(path, size); !s) return s.error();
    Result<std::vector<MetaData>> grids = guarded(path, [&] { return nanovdb::io::readGridMetaData(path); });
    if (!grids) return grids;
    if (grids->empty()) return Error{"not a readable NanoVDB file: it has no grid", path, 0, 0, {}, {}};
    for (const MetaData& grid : *grids) {
        if (grid.gridSize == 0)  // the library ends the program for such a grid
            return damaged(path, "grid '" + grid.gridName + "' is smaller than a grid");
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

/// Reads a grid's tree: checks node by node that it lies within the buffer, before any value is looked up.
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
        return address >= begin && address % NANOVDB_DATA_ALIGNMENT == 0 && address - begin <= size_ &&
               bytes <= size_ - (address - begin);
    }
    /// Checks an offset from the file before a pointer is made of it.
    [[nodiscard]] bool holds(const void* from, std::int64_t offset, std::uint64_t bytes) const {
        const auto size = static_cast<std::int64_t>(size_);
        const std::int64_t start = static_cast<const std::uint8_t*>(from) - begin_;
        if (offset < -size || offset > size || start + offset < 0 || start + offset > size) return false;
        return holds(begin_ + (start + offset), bytes);
    }
    Status read_box(const Root& root);
    Status visit(const Root& root);
    Status visit(const Upper& node, const nanovdb::Coord& origin);
    Status visit(const Lower& node, const nanovdb::Coord& origin);
    Status visit(const Leaf& leaf, const nanovdb::Coord& origin);
    /// Counts bytes of nodes. No nodes share memory, so together they fit into the grid: work is bounded by the file's
    /// size.
    Status count(std::uint64_t bytes) {
        visited_ += bytes;
        return visited_ <= size_ ? success() : damaged(path_, "its nodes overlap");
    }
    /// Takes a cube of voxels that have one value.
    Status take_tile(float value, const nanovdb::Coord& origin, int edge) {
        const float taken = checked(value, origin);
        return taken == background_ ? success() : mark(origin, edge, taken);
    }
    /// Sets the cells within a cube to `value`, and the cells on its border to NaN, since they vary. NaN as `value`
    /// marks all as varying.
    Status mark(const nanovdb::Coord& origin, int edge, float value);
    float checked(float value, const nanovdb::Coord& at) {
        return result_.bad.checked(value, may_be_negative_, at[0], at[1], at[2]);
    }

    const std::uint8_t* begin_;
    std::uint64_t size_;
    const std::string& path_;
    bool may_be_negative_;
    NanoVdbGrid result_;
    CellBox cells_;
    std::vector<float> constant_;  // [cell]; NaN: it varies
    float background_ = 0;
    std::uint64_t visited_ = 0, marked_ = 0;  // bytes of nodes, cells
};

template <class Build>
Result<NanoVdbGrid> TreeReader<Build>::read() {
    const auto* grid = reinterpret_cast<const Grid*>(begin_);
    const auto& tree = grid->tree();
    if (!holds(&tree, static_cast<std::int64_t>(tree.data()->mNodeOffset[3]), sizeof(Root)))
        return damaged(path_, "its tree lies outside of the grid");
    const Root& root = tree.root();
    if (!holds(&root, sizeof(Root) + root.data()->mTableSize * std::uint64_t{sizeof(typename Root::Tile)}))
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
        BadValues passed_over;  // counted per leaf
        VoxelGrid::for_each_point(cells_.side, cell_x, cell_y, cell_z, [&](int x, int y, int z) {
            const auto value = static_cast<float>(accessor.getValue({first[0] + x, first[1] + y, first[2] + z}));
            *to++ = passed_over.checked(value, may_be_negative_, x, y, z);
        });
    };
    result_.values =
        VoxelGrid::build(cells_, 1, fill, [&](int x, int y, int z) { return constant_[cells_.index(x, y, z)]; });
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
        if (least > most) return Error{"the grid has no active voxels", path_, 0, 0, {}, {}};
        if (least < -farthest || most > farthest) return damaged(path_, "its box of voxels has no bounds");
        // Zeros surround the box, and leaves begin at multiples of 8, so cells do too.
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
    background_ = BadValues().checked(static_cast<float>(root.background()), may_be_negative_, 0, 0, 0);
    constant_.assign(cells_.count(), background_);
    return success();
}

template <class Build>
Status TreeReader<Build>::mark(const nanovdb::Coord& origin, int edge, float value) {
    std::array<int, 3> first{}, last{};
    std::array<std::int64_t, 3> from{};
    const int shift = cells_.side == 4 ? 2 : 3;
    std::uint64_t touched = 1;
    for (std::size_t a = 0; a < 3; ++a) {
        // A point on a border also belongs to the previous cell. Shifts round down.
        from[a] = std::int64_t{origin[static_cast<int>(a)]} - result_.origin[a];
        first[a] = static_cast<int>(std::clamp<std::int64_t>((from[a] - 1) >> shift, 0, cells_.size[a]));
        last[a] = static_cast<int>(std::clamp<std::int64_t>((from[a] + edge - 1) >> shift, -1, cells_.size[a] - 1));
        touched *= static_cast<std::uint64_t>(std::max(last[a] - first[a] + 1, 0));
    }
    // Cubes begin at multiples of their edge, at least 8: at most two along each axis meet in a cell.
    marked_ += touched;
    if (marked_ > 8 * std::uint64_t{cells_.count()}) return damaged(path_, "its tiles overlap");
    const auto within = [&](std::size_t a, int cell) {
        const std::int64_t least = std::int64_t{cell} << shift;
        return least >= from[a] && least + cells_.side < from[a] + edge;
    };
    for (int z = first[2]; z <= last[2]; ++z)
        for (int y = first[1]; y <= last[1]; ++y) {
            const bool row_within = within(2, z) && within(1, y);
            for (int x = first[0]; x <= last[0]; ++x)
                constant_[cells_.index(x, y, z)] = row_within && within(0, x) ? value : NAN;
        }
    return success();
}

template <class Build>
Status TreeReader<Build>::visit(const Root& root) {
    constexpr int edge = 4096;
    for (std::uint32_t n = 0; n < root.data()->mTableSize; ++n) {
        const auto* tile = root.data()->tile(n);
        if (!tile->isChild()) {
            if (Status s = take_tile(static_cast<float>(tile->value), tile->origin(), edge); !s) return s;
            continue;
        }
        if (!holds(root.data(), tile->child, sizeof(Upper)))
            return damaged(path_, "an upper node lies outside of the grid");
        if (Status s = visit(*root.data()->getChild(tile), tile->origin()); !s) return s;
    }
    return success();
}

template <class Build>
Status TreeReader<Build>::visit(const Upper& node, const nanovdb::Coord& origin) {
    if (Status s = count(sizeof(Upper)); !s) return s;
    for (std::uint32_t n = 0; n < Upper::SIZE; ++n) {
        const nanovdb::Coord at = origin + (Upper::OffsetToLocalCoord(n) << Lower::TOTAL);
        if (node.data()->mChildMask.isOn(n)) {
            if (!holds(node.data(), node.data()->mTable[n].child, sizeof(Lower)))
                return damaged(path_, "a lower node lies outside of the grid");
            if (Status s = visit(*node.data()->getChild(n), at); !s) return s;
        } else if (Status s = take_tile(static_cast<float>(node.data()->getValue(n)), at, 1 << Lower::TOTAL); !s) {
            return s;
        }
    }
    return success();
}

template <class Build>
Status TreeReader<Build>::visit(const Lower& node, const nanovdb::Coord& origin) {
    if (Status s = count(sizeof(Lower)); !s) return s;
    for (std::uint32_t n = 0; n < Lower::SIZE; ++n) {
        const nanovdb::Coord at = origin + (Lower::OffsetToLocalCoord(n) << Leaf::TOTAL);
        if (node.data()->mChildMask.isOn(n)) {
            if (!holds(node.data(), node.data()->mTable[n].child, sizeof(Leaf)))
                return damaged(path_, "a leaf lies outside of the grid");
            if (Status s = visit(*node.data()->getChild(n), at); !s) return s;
        } else if (Status s = take_tile(static_cast<float>(node.data()->getValue(n)), at, 1 << Leaf::TOTAL); !s) {
            return s;
        }
    }
    return success();
}

template <class Build>
Status TreeReader<Build>::visit(const Leaf& leaf, const nanovdb::Coord& origin) {
    if constexpr (std::is_same_v<Build, nanovdb::FpN>)
        if (!holds(&leaf, leaf.data()->memUsage())) return damaged(path_, "a leaf lies outside of the grid");
    if (Status s = count(sizeof(Leaf)); !s) return s;
    bool any = false;
    for (std::uint32_t n = 0; n < Leaf::SIZE; ++n) {
        const float value = checked(static_cast<float>(leaf.getValue(n)), origin + Leaf::OffsetToLocalCoord(n));
        any = any || value != background_;
    }
    return any ? mark(origin, 1 << Leaf::TOTAL, NAN) : success();
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
    // The library has names of known types only, and reads beyond its table for other types.
    const char* type = handle.gridType() < nanovdb::GridType::End ? nanovdb::toStr(handle.gridType()) : nullptr;
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
        return damaged(path, "grid '" + name + "' is smaller than a grid");
    const auto& data = *reinterpret_cast<const nanovdb::GridData*>(handle->data());
    if (data.mMagic != NANOVDB_MAGIC_NUMBER || data.mGridSize > size)
        return damaged(path, "grid '" + name + "' ends early or has no grid header");
    Result<NanoVdbGrid> read = read_tree(*handle, path, may_be_negative);
    if (!read) return read.error();
    return std::optional(*std::move(read));
}

}  // namespace raylex::transport
