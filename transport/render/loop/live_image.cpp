#include "transport/render/loop/live_image.h"

#include <algorithm>

namespace raylex::transport {

/// Reads tile by tile under the tile's lock, so that no thread waits long.
template <class Read>
std::vector<double> TiledImage::by_tiles(const display::PixelRegion& region, std::size_t components, Read read) const {
    std::vector<double> result(static_cast<std::size_t>(region.width()) * static_cast<std::size_t>(region.height()) *
                               components);
    const int px = grid_.padding_x, py = grid_.padding_y, tile_size = TileGrid::tile_size;
    for (int y = (region.y0 + py) / tile_size; y * tile_size - py < region.y1; ++y)
        for (int x = (region.x0 + px) / tile_size; x * tile_size - px < region.x1; ++x) {
            const display::PixelRegion part{
                std::max(region.x0, x * tile_size - px), std::max(region.y0, y * tile_size - py),
                std::min(region.x1, (x + 1) * tile_size - px), std::min(region.y1, (y + 1) * tile_size - py)};
            std::vector<double> values;
            {
                const std::lock_guard lock(locks_.of(grid_.tile_of(part.x0, part.y0)));
                values = read(part);
            }
            const std::size_t row = static_cast<std::size_t>(part.width()) * components;
            for (int line = 0; line < part.height(); ++line)
                std::copy_n(values.data() + static_cast<std::size_t>(line) * row, row,
                            result.data() + (static_cast<std::size_t>(part.y0 - region.y0 + line) *
                                                 static_cast<std::size_t>(region.width()) +
                                             static_cast<std::size_t>(part.x0 - region.x0)) *
                                                components);
        }
    return result;
}

std::vector<double> TiledImage::resolve(display::ChannelId id, const display::PixelRegion& region) const {
    const auto type = channels_[static_cast<std::size_t>(id)].type;
    return by_tiles(region, static_cast<std::size_t>(display::component_count(type)),
                    [&](const display::PixelRegion& part) { return frame_buffer_.resolve(id, part); });
}

std::vector<double> TiledImage::resolve_alpha(const display::PixelRegion& region) const {
    return by_tiles(region, 1, [&](const display::PixelRegion& part) { return frame_buffer_.resolve_alpha(part); });
}

std::vector<double> TiledImage::resolve_variance_of_mean(display::ChannelId id,
                                                         const display::PixelRegion& region) const {
    const display::ChannelDefinition& channel = channels_[static_cast<std::size_t>(id)];
    if (!channel.statistics) return {};
    return by_tiles(region, static_cast<std::size_t>(display::component_count(channel.type)),
                    [&](const display::PixelRegion& part) { return frame_buffer_.resolve_variance_of_mean(id, part); });
}

}  // namespace raylex::transport
