// An image in bands of rows, one of which is in memory at a time. Images larger than memory are written and shown this
// way. A loader provides the bands: buckets on disk, or merged shards.
#pragma once

#include <functional>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "display/buffer/frame_buffer/frame_buffer.h"

namespace raylex::display {

/// PixelImage::resolve() throws this when a band cannot be loaded.
class BandFailure : public std::runtime_error {
  public:
    explicit BandFailure(Error error) : std::runtime_error(error.message), error_(std::move(error)) {}
    [[nodiscard]] const Error& error() const { return error_; }

  private:
    Error error_;
};

/// Rows [first, end) of an image.
struct RowRange {
    int first = 0, end = 0;
    bool operator==(const RowRange&) const = default;
};

class BandedImage final : public PixelImage {
  public:
    /// Loads a frame buffer of these rows, with layout().first_row. Called for one band at a time, never concurrently.
    using Load = std::function<Result<FrameBuffer>(const RowRange& rows)>;

    /// `bands` are in order and do not overlap. Rows outside all bands have no samples.
    BandedImage(const FrameBufferLayout& layout, std::vector<ChannelDefinition> channels,
                const std::vector<RowRange>& bands, Load load);

    [[nodiscard]] const FrameBufferLayout& layout() const override { return layout_; }
    [[nodiscard]] std::span<const ChannelDefinition> channels() const override { return channels_; }
    [[nodiscard]] int band_end(int y) const override;
    using PixelImage::resolve;
    using PixelImage::resolve_alpha;
    /// These throw BandFailure.
    [[nodiscard]] std::vector<double> resolve(ChannelId id, const PixelRegion& region) const override;
    [[nodiscard]] std::vector<double> resolve_alpha(const PixelRegion& region) const override;

    /// Appends the sums of these rows, loaded from their bands, in the format of FrameBuffer::append_record(). Rows of
    /// a single band are written as loaded.
    Status append_record(std::string& bytes, const RowRange& rows) const;

  private:
    struct Band {
        RowRange rows;
        bool empty = false;  // nothing to load
    };
    template <class Resolve>
    [[nodiscard]] std::vector<double> by_bands(const PixelRegion& region, std::size_t components,
                                               Resolve resolve) const;
    const FrameBuffer& band_of(int y) const;
    [[nodiscard]] Result<FrameBuffer> joined(const RowRange& rows) const;

    FrameBufferLayout layout_;
    std::vector<ChannelDefinition> channels_;
    std::vector<Band> bands_;  // cover all rows
    Load load_;
    mutable std::mutex mutex_;  // guards the members below
    mutable std::optional<FrameBuffer> loaded_;
};

/// Divides the rows [from.first, from.end) into bands of `rows` rows; the last band has the remaining rows.
[[nodiscard]] std::vector<RowRange> bands_of(const RowRange& from, int rows);

}  // namespace raylex::display
