#include "transport/render/tiles.h"

namespace raylex::transport {

TileLocks::Group TileLocks::group(std::uint64_t tile, const TileGrid& grid, bool around) {
    Group group;
    group.locks_ = this;
    const std::uint64_t columns = grid.columns(), x = tile % columns, y = tile / columns, reach = around ? 1 : 0;
    for (std::uint64_t ty = y - std::min(y, reach); ty <= y + reach; ++ty)
        for (std::uint64_t tx = x - std::min(x, reach); tx <= std::min(x + reach, columns - 1); ++tx)
            group.indices_[group.count_++] = (ty * columns + tx) % mutexes_.size();
    const auto end = group.indices_.begin() + static_cast<std::ptrdiff_t>(group.count_);
    std::sort(group.indices_.begin(), end);
    group.count_ = static_cast<std::size_t>(std::unique(group.indices_.begin(), end) - group.indices_.begin());
    return group;
}

}  // namespace raylex::transport
