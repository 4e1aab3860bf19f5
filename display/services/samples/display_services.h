// The calls with which an integrator, pattern or bxdf sends values to display channels (RenderMan's Display Services,
// after their public description). Each thread has one object, bound to its SampleTable.
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

/// The id of the channel with this name, or invalid_channel if the render does not have it.
[[nodiscard]] ChannelId find_channel(std::span<const DisplayChannel> channels, std::string_view name);

/// The name of a channel in an object that outlives renders (a pattern, a material), whose channels differ. A look-up
/// costs one comparison of names.
class NamedChannel {
  public:
    explicit NamedChannel(std::string name) : name_(std::move(name)) {}
    /// The channel's id among those of the render; invalid_channel if it is not requested.
    [[nodiscard]] ChannelId id(std::span<const DisplayChannel> channels) const;
    [[nodiscard]] const std::string& name() const { return name_; }

  private:
    std::string name_;
    mutable std::atomic<std::size_t> last_{0};
};

/// A further sample on a camera ray with its own depth and opacity: light that passes straight through a cutout or a
/// volume.
struct ExtraSample {
    float depth = 0;  ///< distance along the camera ray, world units
    RgbD opacity{1.0};
    bool is_volume = false;
    std::int32_t surface = 0;  ///< see write_surface()
};

/// In all functions `row` is the index of the camera ray in the current integrator call, or a row that add_sample()
/// returned.
///
/// A call for invalid_channel does nothing and returns true, so a channel that the render does not have costs one
/// branch. Other invalid ids, invalid rows, values of the wrong type and values that are not finite (Law 6) are
/// refused: the call returns false and writes nothing. Refusals are counted per channel (`refusals()`), so that the
/// engine warns once per channel at the end of the render, not once per call. The table also counts values that are not
/// finite, by camera ray and channel (SampleTable::invalid_count).
class DisplayServices {
  public:
    /// The first, second and third components of triples, each at least as long as the list of rows.
    using Columns = std::array<const float*, 3>;

    explicit DisplayServices(SampleTable& table);

    /// Adds to the table. Only rgb-like channels take Rgb, only real channels take float; ids cannot be splatted.
    bool splat(ChannelId id, int row, float value);
    bool splat(ChannelId id, int row, const Rgb& value);
    /// Adds the same value to several channels. Returns false if any id was refused; valid channels still get the
    /// value.
    bool splat_multi(std::span<const ChannelId> ids, int row, float value);
    bool splat_multi(std::span<const ChannelId> ids, int row, const Rgb& value);

    /// Overwrites the table entry (never the frame buffer). Rgb is for rgb, point, normal and vector channels, float
    /// for real channels, int32 for integer channels.
    bool write(ChannelId id, int row, float value);
    bool write(ChannelId id, int row, const Rgb& value);
    bool write(ChannelId id, int row, std::int32_t value);
    /// Writes one value per row of a batch: `rows[i]` gets `values[i]`. Returns false if any was refused; valid ones
    /// are written.
    bool write(ChannelId id, std::span<const std::int32_t> rows, std::span<const float> values);
    bool write(ChannelId id, std::span<const std::int32_t> rows, std::span<const Rgb> values);
    bool write(ChannelId id, std::span<const std::int32_t> rows, std::span<const std::int32_t> values);
    /// Writes triples from columns: `rows[i]` gets (columns[0][i], columns[1][i], columns[2][i]).
    bool write(ChannelId id, std::span<const std::int32_t> rows, const Columns& columns);

    /// Overwrites the sample's depth: `distance` along the camera ray in world units; `is_volume` for a scattering or
    /// absorption point inside a medium. Z rules and deep output use it.
    bool write_distance(int row, float distance, bool is_volume = false);
    /// Sets the sample's opacity, from 0 (empty) to 1 (opaque) per colour, from which alpha and deep alpha are
    /// computed. It belongs to the sample and not to a channel. A float means three equal colours.
    bool write_opacity(int row, float opacity) { return write_opacity(row, Rgb(opacity)); }
    bool write_opacity(int row, const Rgb& opacity);
    bool splat_opacity(int row, float opacity) { return splat_opacity(row, Rgb(opacity)); }
    bool splat_opacity(int row, const Rgb& opacity);
    /// Sets the surface of the sample: the renderer's number for it, from 1; 0 for a surface without a name.
    /// Cryptomatte uses it.
    bool write_surface(int row, std::int32_t surface);

    /// Adds a row to the camera ray of `row` and returns it. If the ray already has SampleTable::most_extra_rows, the
    /// sample is merged into the ray's last row, whose opacity grows accordingly, so that the coverage of everything
    /// behind is unchanged; the call counts as refused. Returns -1 for an invalid row or value, which is counted.
    int add_sample(int row, const ExtraSample& sample);

    [[nodiscard]] std::span<const DisplayChannel> get_display_channels() const { return channels_; }

    /// Drops everything that this integrator call sends, before and after this function, to rows and to raster
    /// positions (a Metropolis integrator's start-up). Returns false, and counts as refused, if the call has sent so
    /// many splats (RasterSplats) that some are already in the image.
    bool discard_iteration();

    /// Refused calls so far, without those of discarded iterations, per channel; the last entry counts calls with
    /// invalid ids and calls without a channel (distance, opacity, add_sample).
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
