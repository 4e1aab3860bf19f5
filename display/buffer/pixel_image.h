// An image of resolved pixels in layers, for display and storage. A frame buffer is one, and so is a frame buffer with
// display filters.
#pragma once

#include <span>
#include <vector>

#include "display/services/channel.h"

namespace raylex::display {

struct FrameBufferLayout {
    int width = 0, height = 0;
    int block_size = 16;  ///< samples per canonical block; a power of two
    int quantum_exponent = -80;
    int first_row = 0;  ///< first row in the image if this is a band of its rows: [first_row, first_row + height)

    bool operator==(const FrameBufferLayout&) const = default;
};

/// Pixels [x0, x1) x [y0, y1).
struct PixelRegion {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
    [[nodiscard]] int width() const { return x1 - x0; }
    [[nodiscard]] int height() const { return y1 - y0; }
};

class PixelImage {
  public:
    virtual ~PixelImage() = default;
    PixelImage() = default;
    PixelImage(PixelImage&&) noexcept = default;
    PixelImage& operator=(PixelImage&&) noexcept = default;

    [[nodiscard]] virtual const FrameBufferLayout& layout() const = 0;
    [[nodiscard]] virtual std::span<const ChannelDefinition> channels() const = 0;
    /// The pixels of a channel in a region inside the image, in row order from the top, with interleaved components.
    [[nodiscard]] virtual std::vector<double> resolve(ChannelId id, const PixelRegion& region) const = 0;
    /// The coverage of the pixels in a region.
    [[nodiscard]] virtual std::vector<double> resolve_alpha(const PixelRegion& region) const = 0;

    /// The end of the rows from `y` on that callers should resolve together, channel after channel. An image that does
    /// not fit in memory holds only one such band at a time.
    [[nodiscard]] virtual int band_end(int /*y*/) const { return layout().height; }

    [[nodiscard]] PixelRegion whole() const { return {0, 0, layout().width, layout().height}; }
    [[nodiscard]] std::vector<double> resolve(ChannelId id) const { return resolve(id, whole()); }
    [[nodiscard]] std::vector<double> resolve_alpha() const { return resolve_alpha(whole()); }
};

}  // namespace raylex::display
