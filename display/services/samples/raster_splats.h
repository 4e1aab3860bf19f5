// Splats at any raster position, for integrators whose light paths land anywhere (light tracing, Metropolis). The
// samples of the display services belong to the camera rays of a batch; these splats do not.
//
//     display::Tracker tracker = splats.begin(x, y, path);          // at the camera, after the camera event
//     splats.lpe().move(tracker, ...);                              // the word from the camera to the terminal
//     splats.lpe().contribute(value, technique, tracker);
//
// A contribution reaches beauty and every channel that accepts the path string, with the exact shares, checks and
// counts of the LPE services. `value` is an estimate, per light path, of the camera's measurement per fraction of the
// image's area: a path that finds radiance 1 at a raster position drawn uniformly over the image contributes 1. The
// frame buffer multiplies by the kernel of the pixel filter and divides by the number of light paths per pixel.
#pragma once

#include <algorithm>
#include <span>

#include "display/services/samples/lpe_services.h"
#include "display/services/samples/sample_table.h"

namespace raylex::display {

/// The receiver of finished splats, implemented by the engine.
class RasterSink {
  public:
    virtual ~RasterSink() = default;
    /// Takes a table in which every row is one splat; see FrameBuffer::splat(). It may change the values.
    virtual void take(SampleTable& table) = 0;
};

/// The splats of one integrator call on one thread. They are kept until the call ends, so that discard_iteration() can
/// drop them at any time. A call whose splats fill the memory budget passes some on early, and then can no longer be
/// discarded.
class RasterSplats {
  public:
    static constexpr int capacity = 1024;                                ///< initial number of rows; the table grows by
                                                                         ///< doubling
    static constexpr std::size_t memory_budget = std::size_t{32} << 20;  ///< bytes per thread

    /// `batch` is the table of the call's camera rays. All arguments must outlive this object.
    RasterSplats(const LpeSetup& setup, std::span<const ChannelDefinition> channels, std::uint64_t seed,
                 LpeServices::Attribution attribution, RasterSink& sink, SampleTable& batch)
        : table_(channels, capacity),
          lpe_(setup, table_, seed, attribution),
          sink_(sink),
          batch_(batch),
          most_rows_(rows_within_budget(channels)) {
        table_.begin({});
    }

    /// A tracker for one splat at raster position (x, y), in pixels from the image's top left corner. The position can
    /// be outside the image, where the pixel filter still reaches it. `path` is the camera ray whose pixel and sample
    /// seed random choices; invalid values are logged with it. `weight` multiplies all contributions. The tracker and
    /// its copies are valid until the next call.
    [[nodiscard]] Tracker begin(float x, float y, const CameraRow& path, float weight = 1) {
        CameraRow row = path;
        row.screen_x = x;
        row.screen_y = y;
        row.filter_weight = weight;
        return lpe_.begin(add_row(row));
    }
    /// Adds a splat of known values at where.screen_x and screen_y: three numbers for each of `channels`, which are
    /// expression channels, times `weight`.
    void add(const CameraRow& where, double weight, std::span<const ChannelId> channels, const double* values) {
        const auto row = static_cast<std::size_t>(add_row(where));
        for (std::size_t i = 0; i < channels.size(); ++i) {
            const double* from = values + 3 * i;
            if (from[0] == 0 && from[1] == 0 && from[2] == 0) continue;
            double* to = table_.raw_values(channels[i]) + 3 * row;
            for (std::size_t c = 0; c < 3; ++c) to[c] = weight * from[c];
            table_.touch(channels[i]);
        }
    }
    /// The services with which to move the tracker and to contribute.
    [[nodiscard]] LpeServices& lpe() { return lpe_; }
    [[nodiscard]] const LpeServices& lpe() const { return lpe_; }
    [[nodiscard]] const SampleTable& table() const { return table_; }

    /// Ends an integrator call: passes its splats on, or drops them if the call was discarded.
    void finish() {
        if (batch_.discarded()) return discard();
        if (table_.camera_row_count() == 0) return;
        sink_.take(table_);
        table_.begin({});
    }
    void discard() {
        table_.discard();
        table_.begin({});
    }

  private:
    static int rows_within_budget(std::span<const ChannelDefinition> channels) {
        std::size_t bytes = sizeof(CameraRow) + sizeof(RgbD) + 32;  // 32: other data of a row
        for (const ChannelDefinition& channel : channels)
            bytes +=
                sizeof(SampleTable::RowState) +
                (takes_samples(channel) ? sizeof(double) * static_cast<std::size_t>(component_count(channel.type)) : 0);
        return std::max(capacity, static_cast<int>(memory_budget / bytes));
    }
    int add_row(const CameraRow& row) {
        if (table_.camera_row_count() == table_.max_rows()) [[unlikely]]
            make_room();
        return table_.add_camera_row(row);
    }
    void make_room() {
        if (table_.max_rows() < most_rows_)
            return table_.reserve_camera_rows(std::min(2 * table_.max_rows(), most_rows_));
        if (!batch_.discarded()) batch_.set_handed_on();
        finish();
    }

    SampleTable table_;
    LpeServices lpe_;
    RasterSink& sink_;
    SampleTable& batch_;
    int most_rows_;
};

}  // namespace raylex::display
