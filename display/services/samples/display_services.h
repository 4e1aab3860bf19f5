// What an integrator, pattern or bxdf calls to send values to display channels (RenderMan's Display Services, after
// their public description). One object per thread, bound to that thread's SampleTable.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "display/services/channel.h"
#include "display/services/rgb.h"
#include "display/services/samples/refusals.h"
#include "display/services/samples/sample_table.h"

namespace raylex::display {

/// The id of the channel with this name, or invalid_channel when the render does not have it.
[[nodiscard]] ChannelId find_channel(std::span<const DisplayChannel> channels, std::string_view name);

/// A channel known by name to an object that outlives renders (a pattern, a material), whose channels differ. One
/// comparison of names a call.
class NamedChannel {
  public:
    explicit NamedChannel(std::string name) : name_(std::move(name)) {}
    /// The channel's id among those of the render; invalid_channel where it is not requested.
    [[nodiscard]] ChannelId id(std::span<const DisplayChannel> channels) const;
    [[nodiscard]] const std::string& name() const { return name_; }

  private:
    std::string name_;
    mutable std::atomic<std::size_t> last_{0};
};

/// A sample on the same camera ray with its own depth and opacity: light straight through a cutout or a volume.
struct ExtraSample {
    float depth = 0;  ///< distance along the camera ray, world units
    RgbD opacity{1.0};
    bool is_volume = false;
    std::int32_t surface = 0;  ///< see write_surface
};

/// `row` is the index of the camera ray in the current integrator call, or a row that add_sample returned.
///
/// A call for invalid_channel does nothing and returns true: a channel that the render does not have costs one branch.
/// Other invalid ids, invalid rows, values of the wrong type and values that are not finite (Law 6) are refused: the
/// call returns false and nothing is written. Refusals are counted per channel (`refusals()`), so that the engine warns
/// once per channel when the render is over, and never once per call. Values that are not finite are counted in the
/// table too, by camera ray and channel (SampleTable::invalid_count).
class DisplayServices {
  public:
    /// First, second and third components of triples, each at least as long as the rows they are for.
    using Columns = std::array<const float*, 3>;

    explicit DisplayServices(SampleTable& table);

    /// Accumulates into the table. Only rgb-like channels take Rgb, only real channels take float; ids cannot be
    /// splatted.
    bool splat(ChannelId id, int row, float value);
    bool splat(ChannelId id, int row, const Rgb& value);
    /// The same value into a list of channels. False if any id was refused; the good ones still get the value.
    bool splat_multi(std::span<const ChannelId> ids, int row, float value);
    bool splat_multi(std::span<const ChannelId> ids, int row, const Rgb& value);

    /// Overwrites the table entry (never the frame buffer). Rgb stands for the three numbers of any rgb, point, normal
    /// or vector channel; float goes to real channels and int32 to integer ones.
    bool write(ChannelId id, int row, float value);
    bool write(ChannelId id, int row, const Rgb& value);
    bool write(ChannelId id, int row, std::int32_t value);
    /// A value for each of a batch's rows: `rows[i]` gets `values[i]`. False if any was refused; the good ones are
    /// written.
    bool write(ChannelId id, std::span<const std::int32_t> rows, std::span<const float> values);
    bool write(ChannelId id, std::span<const std::int32_t> rows, std::span<const Rgb> values);
    bool write(ChannelId id, std::span<const std::int32_t> rows, std::span<const std::int32_t> values);
    /// The same of triples by columns: `rows[i]` gets (columns[0][i], columns[1][i], columns[2][i]).
    bool write(ChannelId id, std::span<const std::int32_t> rows, const Columns& columns);

    /// Overwrites the sample's depth: `distance` along the camera ray in world units; `is_volume` for the scattering or
    /// absorption point inside a medium. Drives z rules and deep output.
    bool write_distance(int row, float distance, bool is_volume = false);
    /// The sample's opacity, from 0 (nothing there) to 1 (opaque) per colour: what alpha and deep alpha are made of. It
    /// belongs to the sample, not to a channel. A float stands for three equal colours.
    bool write_opacity(int row, float opacity) { return write_opacity(row, Rgb(opacity)); }
    bool write_opacity(int row, const Rgb& opacity);
    bool splat_opacity(int row, float opacity) { return splat_opacity(row, Rgb(opacity)); }
    bool splat_opacity(int row, const Rgb& opacity);
    /// Says what the sample's opacity belongs to: a number from 1 in the renderer's own count of surfaces, 0 for
    /// nothing that has a name. Cryptomatte and the like look up there.
    bool write_surface(int row, std::int32_t surface);

    /// Adds a row on the camera ray of `row` and returns it. A ray that has SampleTable::most_extra_rows gets no more:
    /// the sample goes into the ray's last row, whose opacity grows by it, so that what lies behind both stays as
    /// covered as it is; the call is counted as refused. -1 where the row is none or a value is not valid (counted).
    int add_sample(int row, const ExtraSample& sample);

    [[nodiscard]] std::span<const DisplayChannel> get_display_channels() const { return channels_; }

    /// Drops everything sent in this integrator call, before and after this call, to rows and to raster positions (a
    /// Metropolis integrator's start-up). False, and counted as refused, when so many splats were sent before
    /// (RasterSplats) that some are in the image already.
    bool discard_iteration();

    /// Calls refused so far without those of discarded iterations, per channel; the last entry counts calls with ids
    /// that are no channel, and those that name no channel (distance, opacity, add_sample).
    [[nodiscard]] std::span<const RefusalCounts> refusals() const { return table_.refusals(); }

  private:
    [[nodiscard]] bool known(ChannelId id) const { return id >= 0 && id < table_.channel_count(); }
    [[nodiscard]] bool takes(ChannelId id, ChannelType type) const {
        return known(id) && takes_samples(table_.channel(id)) && table_.channel(id).type == type;
    }
    [[nodiscard]] bool takes_triples(ChannelId id) const {
        return known(id) && takes_samples(table_.channel(id)) && component_count(table_.channel(id).type) == 3;
    }
    bool refuse(ChannelId id, Refusal reason, std::uint64_t count = 1);
    bool accept(ChannelId id, int row, bool right_type, bool good_value);
    bool accept_row(int row, bool good_value);
    void report(int row) { table_.reported[static_cast<std::size_t>(table_.original(row))] = 1; }
    bool refuse_value(ChannelId id, int row, const Rgb& value);
    bool refuse_row_value(int row, const Rgb& value);
    double* entry(ChannelId id, int row, SampleTable::RowState state);
    template <class Value>
    bool write_batch(ChannelId id, std::span<const std::int32_t> rows, std::span<const Value> values, bool right_type);
    SampleTable& table_;
    std::vector<DisplayChannel> channels_;
};

}  // namespace raylex::display
