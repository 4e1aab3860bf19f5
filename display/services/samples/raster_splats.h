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

/// One thread's splats, handed on many at a time.
class RasterSplats {
  public:
    static constexpr int capacity = 1024;

    /// All of them must outlive this object.
    RasterSplats(const LpeSetup& setup, std::span<const ChannelDefinition> channels, std::uint64_t seed,
                 LpeServices::Attribution attribution, RasterSink& sink)
        : table_(channels, capacity, 0), lpe_(setup, table_, seed, attribution), sink_(sink) {
        table_.begin({});
    }

    /// A tracker for one splat at raster position (x, y), in pixels from the image's top left corner; it may lie
    /// outside where the pixel filter still reaches in. `path` says whose it is (pixel and sample): the seed of choices
    /// and what it takes to render an invalid one again. `weight` multiplies what is contributed. The tracker, and
    /// those copied from it, are good until the next call.
    [[nodiscard]] Tracker begin(float x, float y, const CameraRow& path, float weight = 1) {
        if (table_.camera_row_count() == table_.max_rows()) flush();
        CameraRow row = path;
        row.screen_x = x;
        row.screen_y = y;
        row.filter_weight = weight;
        return lpe_.begin(table_.add_camera_row(row));
    }
    /// A splat of values that are known already, at where.screen_x and screen_y: three numbers for each of `channels`,
    /// all of them expression channels, times `weight`.
    void add(const CameraRow& where, double weight, std::span<const ChannelId> channels, const double* values) {
        if (table_.camera_row_count() == table_.max_rows()) flush();
        const auto row = static_cast<std::size_t>(table_.add_camera_row(where));
        for (std::size_t i = 0; i < channels.size(); ++i) {
            const double* from = values + 3 * i;
            if (from[0] == 0 && from[1] == 0 && from[2] == 0) continue;
            double* to = table_.values(channels[i]) + 3 * row;
            for (std::size_t c = 0; c < 3; ++c) to[c] = weight * from[c];
            table_.touch(channels[i]);
        }
    }
    /// Move and contribute by these and no others.
    [[nodiscard]] LpeServices& lpe() { return lpe_; }
    [[nodiscard]] const LpeServices& lpe() const { return lpe_; }
    [[nodiscard]] const SampleTable& table() const { return table_; }

    /// Hands on all that there is. The engine does so after every integrator call, or discard()s where the integrator
    /// has called discard_iteration(): before its first splat, for when there are many some are handed on at once.
    void flush() {
        if (table_.camera_row_count() == 0) return;
        sink_.take(table_);
        table_.begin({});
    }
    void discard() { table_.begin({}); }

  private:
    SampleTable table_;
    LpeServices lpe_;
    RasterSink& sink_;
};

}  // namespace raylex::display
