// What an integrator, pattern or bxdf calls to send values to display channels (RenderMan's Display Services, after
// their public description). One object per thread, bound to that thread's SampleTable.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "display/services/channel.h"
#include "display/services/rgb.h"
#include "display/services/sample_table.h"

namespace raylex::display {

/// A sample on the same camera ray with its own depth and opacity: light straight through a cutout or a volume.
struct ExtraSample {
    float depth = 0;           ///< distance along the camera ray, world units
    RgbD opacity{1.0};
    bool is_volume = false;
    std::int32_t surface = 0;  ///< see write_surface
};

/// `row` is the index of the camera ray in the current integrator call, or a row that add_sample returned.
///
/// Invalid ids, invalid rows, values of the wrong type and values that are not finite (Law 6) are refused: the call
/// returns false and nothing is written. Refusals are counted per channel (`refused()`), so that the caller can warn once
/// per channel and never once per call.
class DisplayServices {
  public:
    explicit DisplayServices(SampleTable& table);

    /// Accumulates into the table. Only rgb-like channels take Rgb, only real channels take float; ids cannot be splatted.
    bool splat(ChannelId id, int row, float value);
    bool splat(ChannelId id, int row, const Rgb& value);
    /// The same value into a list of channels. False if any id was refused; the good ones still get the value.
    bool splat_multi(std::span<const ChannelId> ids, int row, float value);
    bool splat_multi(std::span<const ChannelId> ids, int row, const Rgb& value);

    /// Overwrites the table entry (never the frame buffer). Rgb stands for the three numbers of any rgb, point, normal or
    /// vector channel; float goes to real channels and int32 to integer ones.
    bool write(ChannelId id, int row, float value);
    bool write(ChannelId id, int row, const Rgb& value);
    bool write(ChannelId id, int row, std::int32_t value);
    /// A value for each of a batch's rows: `rows[i]` gets `values[i]`. False if any was refused; the good ones are written.
    bool write(ChannelId id, std::span<const std::int32_t> rows, std::span<const float> values);
    bool write(ChannelId id, std::span<const std::int32_t> rows, std::span<const Rgb> values);
    bool write(ChannelId id, std::span<const std::int32_t> rows, std::span<const std::int32_t> values);

    /// Overwrites the sample's depth: `distance` along the camera ray in world units; `is_volume` for the scattering or
    /// absorption point inside a medium. Drives z rules and deep output.
    bool write_distance(int row, float distance, bool is_volume = false);
    bool write_opacity(int row, const Rgb& opacity);
    bool splat_opacity(int row, const Rgb& opacity);
    /// Says what the sample's opacity belongs to: a number from 1 in the renderer's own count of surfaces, 0 for nothing
    /// that has a name. Cryptomatte and the like look up there.
    bool write_surface(int row, std::int32_t surface);

    /// Adds a row on the camera ray of `row`; returns it, or -1 when the table is full, the row is none or the depth is
    /// not a number (counted).
    int add_sample(int row, const ExtraSample& sample);

    [[nodiscard]] std::span<const DisplayChannel> get_display_channels() const { return channels_; }

    /// Drops everything sent in this integrator call (a Metropolis integrator's start-up).
    void discard_iteration();

    /// Calls refused so far, per channel; the last entry counts calls with ids that are no channel at all.
    [[nodiscard]] std::span<const std::uint64_t> refused() const { return refused_; }

  private:
    bool accept(ChannelId id, int row, bool fits);
    bool accept_row(int row, bool fits);
    double* entry(ChannelId id, int row, SampleTable::RowState state);
    template <class Value>
    bool write_batch(ChannelId id, std::span<const std::int32_t> rows, std::span<const Value> values, bool fits);
    SampleTable& table_;
    std::vector<DisplayChannel> channels_;
    std::vector<std::uint64_t> refused_;
};

}  // namespace raylex::display
