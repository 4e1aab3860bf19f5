// Splats at any raster position: how an integrator whose light paths land where they will (light tracing, Metropolis)
// reports them. The display services' samples belong to the camera rays of a batch; these belong to nobody.
//
//     display::Tracker tracker = splats.begin(x, y, path);          // at the camera, the camera event read
//     splats.lpe().move(tracker, ...);                              // the word as seen from the camera, terminal and
//     all splats.lpe().contribute(value, technique, tracker);
//
// What is contributed reaches beauty and every channel that accepts the word, with the LPE services' exact shares,
// checks and counts. `value` is an estimate, per light path, of what the camera measures per share of the image's area:
// a path that finds radiance 1 at a raster position drawn evenly over the image contributes 1. The frame buffer
// multiplies by the pixel filter's kernel and divides by the number of light paths a pixel.
#pragma once

#include <algorithm>
#include <span>

#include "display/services/samples/lpe_services.h"
#include "display/services/samples/sample_table.h"

namespace raylex::display {

/// Takes finished splats in: the engine.
class RasterSink {
  public:
    virtual ~RasterSink() = default;
    /// Every row of `table` is one splat; see FrameBuffer::splat. Its values may be changed.
    virtual void take(SampleTable& table) = 0;
};

/// One thread's splats of one integrator call. They stay here until the call is over, so that discard_iteration() drops
/// them at any time; a call whose splats fill the memory budget hands some on early and can no longer be discarded.
class RasterSplats {
  public:
    static constexpr int capacity = 1024;                                ///< rows at first; the table grows by doubling
    static constexpr std::size_t memory_budget = std::size_t{32} << 20;  ///< bytes of a thread's table

    /// `batch` is the table of the call's camera rays. All of them must outlive this object.
    RasterSplats(const LpeSetup& setup, std::span<const ChannelDefinition> channels, std::uint64_t seed,
                 LpeServices::Attribution attribution, RasterSink& sink, SampleTable& batch)
        : table_(channels, capacity),
          lpe_(setup, table_, seed, attribution),
          sink_(sink),
          batch_(batch),
          most_rows_(rows_within_budget(channels)) {
        table_.begin({});
    }

    /// A tracker for one splat at raster position (x, y), in pixels from the image's top left corner; it may lie
    /// outside where the pixel filter still reaches in. `path` names the camera ray whose seed decides random choices
    /// (pixel and sample); invalid values are logged with it. `weight` multiplies what is contributed. The tracker, and
    /// those copied from it, are good until the next call.
    [[nodiscard]] Tracker begin(float x, float y, const CameraRow& path, float weight = 1) {
        CameraRow row = path;
        row.screen_x = x;
        row.screen_y = y;
        row.filter_weight = weight;
        return lpe_.begin(add_row(row));
    }
    /// A splat of values that are known already, at where.screen_x and screen_y: three numbers for each of `channels`,
    /// all of them expression channels, times `weight`.
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
    /// Move and contribute by these and no others.
    [[nodiscard]] LpeServices& lpe() { return lpe_; }
    [[nodiscard]] const LpeServices& lpe() const { return lpe_; }
    [[nodiscard]] const SampleTable& table() const { return table_; }

    /// Ends an integrator call: hands its splats on, or drops them when the call was discarded.
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
        std::size_t bytes = sizeof(CameraRow) + sizeof(RgbD) + 32;  // 32: what else a row has
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
