// What an integrator, pattern or bxdf calls to send values to display channels (RenderMan's Display Services, after
// their public description). One object per thread, bound to that thread's SampleTable.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "display/services/channel.h"
#include "display/services/rgb.h"
#include "display/services/samples/sample_table.h"

namespace raylex::display {

/// A sample on the same camera ray with its own depth and opacity: light straight through a cutout or a volume.
struct ExtraSample {
    float depth = 0;  ///< distance along the camera ray, world units
    RgbD opacity{1.0};
    bool is_volume = false;
    std::int32_t surface = 0;  ///< see write_surface
};

/// Why a call was refused.
enum class Refusal : std::uint8_t {
    unknown_channel,  ///< the id is no channel of this render
    unknown_row,      ///< the row is none of this batch
    wrong_type,       ///< the channel holds another type
    bad_value,        ///< not finite (Law 6), or a negative surface number
    no_room           ///< add_sample: the table holds no more rows
};
inline constexpr int refusal_kinds = 5;

/// Refused calls by reason.
struct RefusalCounts {
    std::array<std::uint64_t, refusal_kinds> by{};

    [[nodiscard]] std::uint64_t of(Refusal reason) const { return by[static_cast<std::size_t>(reason)]; }
    [[nodiscard]] std::uint64_t total() const;
    void add(const RefusalCounts& other);
    bool operator==(const RefusalCounts&) const = default;
};

/// One sentence per channel that refused calls, with how many and why; calls that name no channel come last. `refusals`
/// has an entry per channel and one more.
std::vector<std::string> refusal_warnings(std::span<const ChannelDefinition> channels,
                                          std::span<const RefusalCounts> refusals);

/// `row` is the index of the camera ray in the current integrator call, or a row that add_sample returned.
///
/// Invalid ids, invalid rows, values of the wrong type and values that are not finite (Law 6) are refused: the call
/// returns false and nothing is written. Refusals are counted per channel (`refusals()`), so that the engine warns once
/// per channel when the render is over, and never once per call. Values that are not finite are counted in the table
/// too, by camera ray and channel (SampleTable::invalid_count).
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

    /// Adds a row on the camera ray of `row` and returns it. When the table is full the sample goes into the ray's last
    /// one, whose opacity grows by it: what lies behind both stays as covered as it is. -1 where the ray has none, the
    /// row is none or the depth is not a number (counted).
    int add_sample(int row, const ExtraSample& sample);

    [[nodiscard]] std::span<const DisplayChannel> get_display_channels() const { return channels_; }

    /// Drops everything sent in this integrator call (a Metropolis integrator's start-up).
    void discard_iteration();

    /// Calls refused so far, per channel; the last entry counts calls with ids that are no channel, and those that name
    /// no channel (distance, opacity, add_sample).
    [[nodiscard]] std::span<const RefusalCounts> refusals() const { return refusals_; }

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
    bool refuse_value(ChannelId id, int row, const Rgb& value);
    bool refuse_row_value(int row, const Rgb& value);
    double* entry(ChannelId id, int row, SampleTable::RowState state);
    template <class Value>
    bool write_batch(ChannelId id, std::span<const std::int32_t> rows, std::span<const Value> values, bool right_type);
    SampleTable& table_;
    std::vector<DisplayChannel> channels_;
    std::vector<RefusalCounts> refusals_;
};

}  // namespace raylex::display
