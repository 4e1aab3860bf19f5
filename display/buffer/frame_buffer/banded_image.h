// An image in bands of rows, one of which is in memory at a time: what is larger than memory is written and shown by
// this door. Where the bands come from, a loader knows: buckets on disk, shards that are added up.
#pragma once

#include <functional>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "display/buffer/frame_buffer/frame_buffer.h"

namespace raylex::display {

/// What PixelImage::resolve() throws where a band cannot be had.
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
    /// A frame buffer of these rows, with layout().first_row; called for one band after another, never twice at once.
    using Load = std::function<Result<FrameBuffer>(const RowRange& rows)>;

    /// `bands` are in order and share no row; rows that are in none are pixels without samples.
    BandedImage(const FrameBufferLayout& layout, std::vector<ChannelDefinition> channels,
                const std::vector<RowRange>& bands, Load load);

    [[nodiscard]] const FrameBufferLayout& layout() const override { return layout_; }
    [[nodiscard]] std::span<const ChannelDefinition> channels() const override { return channels_; }
    [[nodiscard]] int band_end(int y) const override;
    using PixelImage::resolve;
    using PixelImage::resolve_alpha;
    /// Throw BandFailure.
    [[nodiscard]] std::vector<double> resolve(ChannelId id, const PixelRegion& region) const override;
    [[nodiscard]] std::vector<double> resolve_alpha(const PixelRegion& region) const override;

    /// The sums of these rows, taken from the bands that have them, as FrameBuffer::append_record() writes them. Rows
    /// of one band are packed as they are.
    Status append_record(std::string& bytes, const RowRange& rows) const;

  private:
    struct Band {
        RowRange rows;
        bool empty = false;  // there is nothing to load
    };
    template <class Resolve>
    [[nodiscard]] std::vector<double> by_bands(const PixelRegion& region, std::size_t components,
                                               Resolve resolve) const;
    const FrameBuffer& band_of(int y) const;
    [[nodiscard]] Result<FrameBuffer> joined(const RowRange& rows) const;

    FrameBufferLayout layout_;
    std::vector<ChannelDefinition> channels_;
    std::vector<Band> bands_;  // all rows
    Load load_;
    mutable std::mutex mutex_;  // of what follows
    mutable std::optional<FrameBuffer> loaded_;
};

/// Rows from `from.first` to `from.end` in bands of `rows`, the last of what is left.
[[nodiscard]] std::vector<RowRange> bands_of(const RowRange& from, int rows);

}  // namespace raylex::display
