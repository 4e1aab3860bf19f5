#include "transport/render/tiles.h"

namespace raylex::transport {

TileLocks::Group TileLocks::group(std::uint64_t tile, const TileGrid& grid, bool around) {
    Group group;
    group.locks_ = this;
    const std::uint64_t columns = grid.columns(), x = tile % columns, y = tile / columns, reach = around ? 1 : 0;
    const auto begin = group.indices_.begin();
    for (std::uint64_t ty = y - std::min(y, reach); ty <= y + reach; ++ty)
        for (std::uint64_t tx = x - std::min(x, reach); tx <= std::min(x + reach, columns - 1); ++tx) {
            const std::size_t index = (ty * columns + tx) % mutexes_.size();
            const auto end = begin + static_cast<std::ptrdiff_t>(group.count_);
            const auto at = std::lower_bound(begin, end, index);
            if (at != end && *at == index) continue;
            std::copy_backward(at, end, end + 1);
            *at = index;
            ++group.count_;
        }
    return group;
}

}  // namespace raylex::transport
