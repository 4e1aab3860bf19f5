// The table between integrators and the frame buffer: [channel][camera ray + extra rows], one per thread.
//
// Integrators fill it through DisplayServices and LpeServices; sample filters read and change it; then the frame buffer
// takes it in. Values are double, so that a split's layers and beauty differ by no more than double rounding (Law 1).
// Rows of one pixel stand together, in ascending sample order; extra rows (AddSample) follow all camera rays.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "display/services/channel.h"
#include "display/services/rgb.h"

namespace raylex::display {

/// What the engine knows of a camera ray before it is traced. One entry per row.
struct CameraRow {
    std::int32_t pixel_x = 0, pixel_y = 0;   ///< raster index; the pixel this sample belongs to (importance mode)
    float screen_x = 0, screen_y = 0;        ///< sub-pixel raster position the ray was sent through
    float filter_weight = 1;                 ///< importance mode: sign (and size) of the kernel over its sampling density
    float shutter_time = 0;                  ///< in [0, 1)
    std::uint64_t sample = 0;                ///< sample index within the pixel
};

class SampleTable {
  public:
    /// `max_rows` camera rays and `max_extra_rows` rows from add_sample fit in; more extra rows are refused and counted.
    SampleTable(std::span<const ChannelDefinition> channels, int max_rows, int max_extra_rows);

    /// Empties the table for a new batch: rows() are cleared only where the last batch touched them.
    void begin(std::span<const CameraRow> rows);
    /// Drops everything sent since begin(); the batch then leaves no trace in the frame buffer.
    void discard();
    [[nodiscard]] bool discarded() const { return discarded_; }

    [[nodiscard]] int camera_row_count() const { return camera_row_count_; }
    [[nodiscard]] int row_count() const { return row_count_; }   ///< camera rows and extra rows
    [[nodiscard]] int channel_count() const { return static_cast<int>(channels_.size()); }
    [[nodiscard]] const ChannelDefinition& channel(ChannelId id) const { return channels_[static_cast<std::size_t>(id)]; }
    [[nodiscard]] const CameraRow& camera_row(int row) const { return camera_rows_[static_cast<std::size_t>(original(row))]; }
    /// The camera row that an extra row belongs to; a camera row's own index.
    [[nodiscard]] int original(int row) const { return originals_[static_cast<std::size_t>(row)]; }
    int add_row(int original);                                   ///< -1 when the table is full

    /// Values of one channel, component-interleaved per row. Writable for sample filters.
    [[nodiscard]] double* values(ChannelId id) { return values_.data() + offset_[static_cast<std::size_t>(id)]; }
    [[nodiscard]] const double* values(ChannelId id) const { return values_.data() + offset_[static_cast<std::size_t>(id)]; }
    [[nodiscard]] bool touched(ChannelId id) const { return touched_[static_cast<std::size_t>(id)] != 0; }
    void touch(ChannelId id) { touched_[static_cast<std::size_t>(id)] = 1; }
    /// Whether a Write (not a Splat) set this row: rows without one keep the channel's miss value.
    [[nodiscard]] bool written(ChannelId id, int row) const;
    void mark_written(ChannelId id, int row);

    std::vector<float> depth;          ///< [row] hit distance or what WriteDistance said; +inf for a miss
    std::vector<std::uint8_t> is_volume;
    std::vector<RgbD> opacity;         ///< [row] 0 = nothing hit, 1 = opaque
    std::vector<std::uint8_t> valid;   ///< [row] 0 marks a row whose camera ray could not be traced

  private:
    std::vector<ChannelDefinition> channels_;
    std::vector<std::size_t> offset_;      // [channel] into values_
    std::vector<double> values_;
    std::vector<std::uint8_t> touched_;    // [channel]
    std::vector<std::uint8_t> written_;    // [channel * row_capacity_ + row], plain AOVs only
    std::vector<CameraRow> camera_rows_;
    std::vector<std::int32_t> originals_;
    int row_capacity_ = 0, camera_row_count_ = 0, row_count_ = 0;
    bool discarded_ = false;
};

}  // namespace raylex::display
