// Divides an image into tiles of pixels, whose samples come in aligned blocks.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <mutex>

#include "display/buffer/frame_buffer/frame_buffer.h"

namespace raylex::transport {

/// The tiles of an image with padding around it, and the pixels that get samples.
struct TileGrid {
    static constexpr int tile_size = 16;   ///< pixels along a side
    static constexpr int block_size = 16;  ///< samples; the frame buffer's unit of exact addition

    int width = 0, height = 0;         ///< of the image
    int padding_x = 0, padding_y = 0;  ///< pixels around the image whose samples reach into it
    display::PixelRegion region;       ///< the pixels that get samples; without a crop they include the padding

    [[nodiscard]] std::uint64_t columns() const { return along(width, padding_x); }
    [[nodiscard]] std::uint64_t rows() const { return along(height, padding_y); }
    [[nodiscard]] std::uint64_t count() const { return columns() * rows(); }
    [[nodiscard]] std::uint64_t tile_of(int x, int y) const {
        return static_cast<std::uint64_t>((y + padding_y) / tile_size) * columns() +
               static_cast<std::uint64_t>((x + padding_x) / tile_size);
    }
    /// All pixels of a tile, including those outside of the region.
    [[nodiscard]] display::PixelRegion pixels_of(std::uint64_t tile) const {
        const int x = static_cast<int>(tile % columns()) * tile_size - padding_x,
                  y = static_cast<int>(tile / columns()) * tile_size - padding_y;
        return {x, y, x + tile_size, y + tile_size};
    }
    /// Calls visit(x, y) for the tile's pixels of the region, along the Morton curve: batches cover compact squares,
    /// whose rays are coherent.
    template <class Visit>
    void for_each_pixel(std::uint64_t tile, const Visit& visit) const {
        const display::PixelRegion pixels = pixels_of(tile);
        for (int m = 0; m < tile_size * tile_size; ++m) {
            int x = pixels.x0, y = pixels.y0;
            for (int bit = 0; (1 << bit) < tile_size; ++bit) {
                x += ((m >> (2 * bit)) & 1) << bit;
                y += ((m >> (2 * bit + 1)) & 1) << bit;
            }
            if (x >= region.x0 && x < region.x1 && y >= region.y0 && y < region.y1) visit(x, y);
        }
    }
    /// The tiles with pixels of the region, row by row: their number, and each tile.
    [[nodiscard]] std::uint64_t region_count() const {
        return static_cast<std::uint64_t>(region_columns()) *
               static_cast<std::uint64_t>((region.y1 - 1 + padding_y) / tile_size - first_row() + 1);
    }
    [[nodiscard]] std::uint64_t region_tile(std::uint64_t i) const {
        const auto across = static_cast<std::uint64_t>(region_columns());
        return (static_cast<std::uint64_t>(first_row()) + i / across) * columns() +
               static_cast<std::uint64_t>((region.x0 + padding_x) / tile_size) + i % across;
    }
    /// The number of blocks that contain this many samples of a pixel.
    [[nodiscard]] static std::uint64_t blocks_for(std::uint64_t samples) {
        return (samples + block_size - 1) / block_size;
    }

  private:
    [[nodiscard]] int first_row() const { return (region.y0 + padding_y) / tile_size; }
    [[nodiscard]] int region_columns() const {
        return (region.x1 - 1 + padding_x) / tile_size - (region.x0 + padding_x) / tile_size + 1;
    }
    [[nodiscard]] static std::uint64_t along(int size, int padding) {
        return static_cast<std::uint64_t>((size + 2 * padding + tile_size - 1) / tile_size);
    }
};

/// Locks of the tiles whose pixels are being added: two threads may hold different blocks of one tile, and the frame
/// buffer needs one caller per pixel. Striped by tile, taken once a batch, and rarely contended on images of many
/// tiles. In splat mode a batch also adds to the surrounding tiles, and locks them all.
class TileLocks {
  public:
    /// Locks its mutexes in the same order as all groups, so that no two wait for each other.
    class Group {
      public:
        void lock() {
            for (std::size_t i = 0; i < count_; ++i) locks_->mutexes_[indices_[i]].lock();
        }
        void unlock() {
            for (std::size_t i = count_; i-- > 0;) locks_->mutexes_[indices_[i]].unlock();
        }

      private:
        friend class TileLocks;
        TileLocks* locks_ = nullptr;
        std::array<std::size_t, 9> indices_{};
        std::size_t count_ = 0;
    };

    [[nodiscard]] std::mutex& of(std::uint64_t tile) { return mutexes_[tile % mutexes_.size()]; }
    /// The locks of the tile, and with `around` those of its neighbours.
    [[nodiscard]] Group group(std::uint64_t tile, const TileGrid& grid, bool around);

  private:
    std::array<std::mutex, 256> mutexes_;
};

}  // namespace raylex::transport
