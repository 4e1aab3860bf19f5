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
};

/// `row` is the index of the camera ray in the current integrator call, or a row that add_sample returned.
///
/// Invalid ids, invalid rows and values of the wrong type are refused: the call returns false, nothing is written, and
/// one warning per channel is counted (`refused()`), never one per call.
class DisplayServices {
  public:
    explicit DisplayServices(SampleTable& table);

    /// Accumulates into the table. Only rgb-like channels take Rgb, only real channels take float; ids cannot be splatted.
    bool splat(ChannelId id, int row, float value);
    bool splat(ChannelId id, int row, const Rgb& value);
    /// The same value into a list of channels. False if any id was refused; the good ones still get the value.
    bool splat_multi(std::span<const ChannelId> ids, int row, float value);
    bool splat_multi(std::span<const ChannelId> ids, int row, const Rgb& value);

    /// Overwrites the table entry (never the frame buffer).
    bool write(ChannelId id, int row, float value);
    bool write(ChannelId id, int row, const Rgb& value);
    bool write(ChannelId id, int row, std::int32_t value);

    /// Overwrites the sample's depth: `distance` along the camera ray in world units; `is_volume` for the scattering or
    /// absorption point inside a medium. Drives z rules and deep output.
    bool write_distance(int row, float distance, bool is_volume = false);
    bool write_opacity(int row, const Rgb& opacity);
    bool splat_opacity(int row, const Rgb& opacity);

    /// Adds a row on the camera ray of `row`; returns it, or -1 when the table is full (counted).
    int add_sample(int row, const ExtraSample& sample);

    [[nodiscard]] std::span<const DisplayChannel> get_display_channels() const { return channels_; }

    /// Drops everything sent in this integrator call (a Metropolis integrator's start-up).
    void discard_iteration();

    /// Calls refused so far, per channel; the last entry counts calls with ids that are no channel at all.
    [[nodiscard]] std::span<const std::uint64_t> refused() const { return refused_; }

  private:
    bool accept(ChannelId id, int row, bool type_fits);
    SampleTable& table_;
    std::vector<DisplayChannel> channels_;
    std::vector<std::uint64_t> refused_;
};

}  // namespace raylex::display
