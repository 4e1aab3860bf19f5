// The table between integrators and the frame buffer: [channel][camera ray + extra rows], one per thread.
//
// Integrators fill it through DisplayServices and LpeServices; sample filters read and change it; then the frame buffer
// adds it. Values are double, so that a split's layers and beauty differ only by double rounding (Law 1). Rows of one
// pixel are consecutive, in ascending sample order; extra rows (AddSample) follow all camera rays. The table grows when
// extra rows need memory, and keeps its size, so renders without extra rows pay nothing for them.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "display/services/channel.h"
#include "display/services/rgb.h"
#include "display/services/samples/refusals.h"
#include "display/services/samples/splat_sets.h"

namespace raylex::display {

class BatchPathStrings;
class PathAlphabet;

/// The data of a camera ray before it is traced, one entry per row.
struct CameraRow {
    std::int32_t pixel_x = 0, pixel_y = 0;  ///< raster index of the pixel that the sample belongs to (importance mode)
    float screen_x = 0, screen_y = 0;       ///< sub-pixel raster position of the ray
    float filter_weight = 1;                ///< importance mode: kernel value over sampling density, with its sign
    float shutter_time = 0;                 ///< in [0, 1)
    std::uint64_t sample = 0;               ///< sample index within the pixel
};

/// A refused value (not finite or out of range), with the data for rendering the sample again (Law 6).
struct InvalidSample {
    std::int32_t pixel_x = 0, pixel_y = 0;
    std::uint64_t sample = 0;
    Rgb value;
    ChannelId channel = invalid_channel;  ///< channel of the value; invalid_channel: light, for beauty and layers
};

class SampleTable {
  public:
    static constexpr std::size_t invalid_samples_kept = 16;
    /// Light in the layout of the processor's registers: (unused, red), (green, blue).
    using Pair [[gnu::vector_size(16), gnu::may_alias]] = double;
    struct Light {
        Pair first, second;
    };
    /// Sets that occur in a batch get places in chunks; each chunk has one bit per place.
    static constexpr std::size_t set_chunk = 256;
    using SetMask = std::array<std::uint64_t, set_chunk / 64>;

    /// How a row of a plain channel got its value. Expression channels and beauty stay `untouched`: they start at 0 and
    /// add up. Splatted values of a camera ray's rows add up, written ones are composited (see FrameBuffer).
    enum class RowState : std::uint8_t { untouched, splatted, written };

    /// The limit per camera ray, above which add_row() refuses rows. It applies to each ray separately, so the rows of
    /// one ray never depend on the other rays of its batch.
    static constexpr int most_extra_rows = 1024;

    /// Makes room for `max_rows` camera rays. `sets`, which must outlive the table, makes channels share values; null:
    /// each channel has its own values.
    SampleTable(std::span<const ChannelDefinition> channels, int max_rows, const SplatSets* sets = nullptr);

    SampleTable(SampleTable&&) noexcept;
    ~SampleTable();

    /// Empties the table for a new batch of at most max_rows() rays; clears rows only where the last batch touched
    /// them.
    void begin(std::span<const CameraRow> rows);
    /// Adds one camera row at the end, for rows that become known one by one. There must be no extra rows yet. Returns
    /// -1 if the table is full.
    int add_camera_row(const CameraRow& camera);
    /// Makes room for `max_rows` camera rows. Rows keep their indices and values.
    void reserve_camera_rows(int max_rows);
    /// Drops everything sent since begin(), and everything sent until the next begin(): the batch then leaves no trace
    /// in the frame buffer, in sinks or in counters. After set_handed_on() it drops nothing and returns false.
    bool discard();
    [[nodiscard]] bool discarded() const { return discarded_; }
    /// Records that splats of this batch are already in the image.
    void set_handed_on() { handed_on_ = true; }

    [[nodiscard]] int max_rows() const { return max_rows_; }
    [[nodiscard]] int camera_row_count() const { return camera_row_count_; }
    [[nodiscard]] int row_count() const { return row_count_; }  ///< camera rows and extra rows
    [[nodiscard]] int channel_count() const { return static_cast<int>(channels_.size()); }
    [[nodiscard]] std::span<const ChannelDefinition> channels() const { return channels_; }
    [[nodiscard]] const ChannelDefinition& channel(ChannelId id) const {
        return channels_[static_cast<std::size_t>(id)];
    }
    [[nodiscard]] const CameraRow& camera_row(int row) const {
        return camera_rows_[static_cast<std::size_t>(original(row))];
    }
    /// The camera row of an extra row; for a camera row its own index.
    [[nodiscard]] int original(int row) const { return originals_[static_cast<std::size_t>(row)]; }
    /// Adds a row to the camera ray of `row`. Returns -1 if the ray has most_extra_rows. The call invalidates pointers
    /// into the table.
    int add_row(int row);
    /// The last extra row of the same camera ray; -1 if it has none.
    [[nodiscard]] int last_row_of(int row) const { return extra_rows_[static_cast<std::size_t>(original(row))].last; }

    /// The values of one channel, component-interleaved per row. A row without values is 0 in an expression channel and
    /// the channel's miss value in a plain one.
    [[nodiscard]] const double* values(ChannelId id) const {
        return values_.data() + offset_[static_cast<std::size_t>(id)];
    }
    /// The numbers of one row of a channel, for a sample filter to change. They count as sent: a plain channel's row
    /// counts as written, unless it has splats.
    [[nodiscard]] std::span<double> edit(ChannelId id, int row) {
        touch(id, row);
        if (channel(id).style == ChannelStyle::name && row_state(id, row) == RowState::untouched)
            set_row_state(id, row, RowState::written);
        const auto components = static_cast<std::size_t>(component_count(channel(id).type));
        return {raw_values(id) + static_cast<std::size_t>(row) * components, components};
    }
    /// The memory of values(), for services that call touch() and set_row_state() themselves. Values written without
    /// these calls are lost.
    [[nodiscard]] double* raw_values(ChannelId id) { return values_.data() + offset_[static_cast<std::size_t>(id)]; }
    /// Touched rows are recorded in stripes, because most of many channels get nothing from the samples of one pixel.
    [[nodiscard]] bool touched(ChannelId id) const { return touched_[static_cast<std::size_t>(id)] != 0; }
    void touch(ChannelId id, int row) {
        touch_in_passing(id, row);
        sent_separately_ |= shared_[static_cast<std::size_t>(id)];
    }
    void touch(ChannelId id) {  ///< all rows
        touched_[static_cast<std::size_t>(id)] = ~std::uint64_t{0};
        sent_separately_ |= shared_[static_cast<std::size_t>(id)];
    }
    /// Records a touched row of a channel for its regular light, that is, without marking it as sent apart.
    void touch_in_passing(ChannelId id, int row) {
        touched_[static_cast<std::size_t>(id)] |= std::uint64_t{1} << (row >> stripe_shift_);
    }
    /// Returns whether any batch that was not discarded sent a value to the channel.
    [[nodiscard]] bool ever_touched(ChannelId id) const {
        return ever_touched_[static_cast<std::size_t>(id)] != 0 || (touched(id) && !discarded_);
    }

    /// The sets of channels that share values in this batch; null if each channel has only its own values.
    [[nodiscard]] const SplatSets* sets() const { return sets_; }
    /// Adds light, times the filter weight of the row's camera ray, to the sum of a set for the row's block. A sum is
    /// in the order of these calls: additions to one block must come in the same order whatever else is in the batch
    /// (Law 3).
    void add_to_set(std::size_t set, int row, const Light& light) {
        std::int32_t place = place_of_set_[set];
        if (place < 0) [[unlikely]]
            place = add_set(set);
        const SetRow of = set_rows_[static_cast<std::size_t>(row)];
        const auto at = static_cast<std::size_t>(place) % set_chunk;
        SetChunk& chunk = set_chunks_[static_cast<std::size_t>(place) / set_chunk];
        chunk.masks[of.block][at / 64] |= std::uint64_t{1} << at % 64;
        auto* const sum = reinterpret_cast<Pair*>(&chunk.sums[of.block * set_stride + at]);
        const double weight = static_cast<double>(of.weight);
        sum[0] += light.first * weight;
        sum[1] += light.second * weight;
    }
    /// The sets that occur in this batch, by place.
    [[nodiscard]] std::span<const std::uint32_t> sets_in_use() const { return sets_in_use_; }
    /// The places of a chunk with additions for the block of this camera row. set_sum() gives the sum at one place.
    [[nodiscard]] const SetMask& set_mask(int row, std::size_t chunk) const {
        return set_chunks_[chunk].masks[set_rows_[static_cast<std::size_t>(row)].block];
    }
    [[nodiscard]] std::array<double, 3> set_sum(int row, std::size_t place) const {
        const std::size_t block = set_rows_[static_cast<std::size_t>(row)].block;
        const SetSum& sum = set_chunks_[place / set_chunk].sums[block * set_stride + place % set_chunk];
        return {sum.r, sum.g, sum.b};
    }
    /// Returns whether a channel with sets also got values of its own, which add to those of the sets.
    [[nodiscard]] bool sent_separately() const { return sent_separately_ != 0; }

    /// [channel] the touched stripes, to compare with stripes_of().
    [[nodiscard]] std::span<const std::uint64_t> touched_stripes() const { return touched_; }
    /// The stripes of rows [begin, end), which must not be empty.
    [[nodiscard]] std::uint64_t stripes_of(int begin, int end) const {
        const int first = begin >> stripe_shift_, last = (end - 1) >> stripe_shift_;
        return (~std::uint64_t{0} >> (63 - (last - first))) << first;
    }
    /// The value of the channel's rows before anything is sent to them.
    [[nodiscard]] double fill_value(ChannelId id) const { return fill_[static_cast<std::size_t>(id)]; }
    /// Returns whether a Write or a Splat set this row; other rows keep the channel's miss value.
    [[nodiscard]] bool written(ChannelId id, int row) const { return row_state(id, row) != RowState::untouched; }
    [[nodiscard]] RowState row_state(ChannelId id, int row) const {
        return row_states_[static_cast<std::size_t>(id) * row_capacity_ + static_cast<std::size_t>(row)];
    }
    void set_row_state(ChannelId id, int row, RowState state) {
        row_states_[static_cast<std::size_t>(id) * row_capacity_ + static_cast<std::size_t>(row)] = state;
    }
    void set_row_states(ChannelId id, int first, int count, RowState state) {
        std::fill_n(row_states_.data() + static_cast<std::size_t>(id) * row_capacity_ + static_cast<std::size_t>(first),
                    count, state);
    }

    /// Makes the table keep the path strings of its light, in an alphabet that outlives it, and the light of each one.
    BatchPathStrings& keep_path_strings(const PathAlphabet& alphabet);
    /// Null if path strings are not kept. An atlas stores its number of each path string in them.
    [[nodiscard]] BatchPathStrings* words() const { return words_.get(); }

    std::vector<float> depth;  ///< [row] hit distance or the value of WriteDistance; +inf for a miss
    std::vector<std::uint8_t> is_volume;
    std::vector<RgbD> opacity;          ///< [row] 0 = nothing hit, 1 = opaque
    std::vector<std::int32_t> surface;  ///< [row] surface number, 1-based in the renderer's count; 0 = no name
    std::vector<std::uint8_t>
        valid;  ///< [row] 0 marks a camera ray that could not be traced; it counts as a black miss
    /// [camera row] whether the integrator wrote a distance, an opacity or a surface, or added a row. If not, the
    /// renderer supplies them (CameraHits).
    std::vector<std::uint8_t> reported;

    /// Counts a refused value of `row` for its camera ray and `channel`, and logs it while there is room. Call it once
    /// per refused value, and count_invalid_of() for each further channel that would have taken it.
    void count_invalid(int row, ChannelId channel, const Rgb& value);
    void count_invalid_of(ChannelId channel);
    /// Counts refused calls for a channel; invalid_channel: calls without a channel.
    void count_refusal(ChannelId channel, Refusal reason, std::uint64_t count);
    /// Number of refused values of a camera ray since begin(), for the AOV invalidSamples.
    [[nodiscard]] std::uint32_t invalid_count(int camera_row) const {
        return invalid_[static_cast<std::size_t>(camera_row)];
    }
    /// Refused values since the table was made, without discarded batches: in total, [channel], and the first ones.
    [[nodiscard]] std::uint64_t invalid_total() const { return counts_.invalid; }
    [[nodiscard]] std::span<const std::uint64_t> invalid_by_channel() const { return counts_.invalid_by_channel; }
    [[nodiscard]] std::span<const InvalidSample> invalid_log() const { return counts_.invalid_log; }
    /// Refused calls since the table was made, without discarded batches: [channel]; the last entry is for calls
    /// without one.
    [[nodiscard]] std::span<const RefusalCounts> refusals() const { return counts_.refusals; }

  private:
    /// Counters of refused values and calls.
    struct Counts {
        std::uint64_t invalid = 0;
        std::vector<std::uint64_t> invalid_by_channel;
        std::vector<InvalidSample> invalid_log;
        std::vector<RefusalCounts> refusals;
    };
    /// The extra rows of one camera ray.
    struct ExtraRowsOfRay {
        std::int32_t last = -1, count = 0;
    };
    [[nodiscard]] bool counts_now();
    void reserve_rows(std::size_t capacity);
    void clear_row(std::size_t row);
    void clear_rows(int count);
    void clear_channel(std::size_t channel, std::size_t values, double fill, std::size_t rows);
    void clear_sets();
    std::int32_t add_set(std::size_t set);
    void find_set_blocks(std::size_t first_row, std::size_t end_row);

    struct alignas(32) SetSum {
        double nothing, r, g, b;
    };
    /// The block in which the row's samples are summed, and their weight.
    struct SetRow {
        std::uint32_t block;
        float weight;
    };
    /// An odd number of cache lines, so that blocks do not all map to the same few sets of the cache.
    static constexpr std::size_t set_stride = set_chunk + 2;
    struct SetChunk {
        std::vector<SetSum> sums;    // [block * set_stride + place]; 0 unless `masks` marks it
        std::vector<SetMask> masks;  // [block]
    };
    std::unique_ptr<BatchPathStrings> words_;
    const SplatSets* sets_ = nullptr;
    std::vector<std::int32_t> place_of_set_;  // [set] negative: not in this batch
    std::vector<std::uint32_t> sets_in_use_;  // [place]
    std::vector<SetChunk> set_chunks_;
    std::vector<SetRow> set_rows_;      // [row]
    std::uint32_t set_blocks_ = 0;      // number of blocks in this batch
    std::vector<std::uint8_t> shared_;  // [channel]
    std::uint8_t sent_separately_ = 0;
    std::vector<std::uint32_t> invalid_;  // [camera row]
    Counts counts_, counts_before_;       // counts_before_: at the begin of the batch
    bool counts_changed_ = false;         // since the begin of the batch
    std::vector<ChannelDefinition> channels_;
    std::vector<std::size_t> offset_;  // [channel] offset into values_
    std::vector<double> values_;
    std::vector<double> fill_;                // [channel]
    std::vector<std::uint64_t> touched_;      // [channel] one bit per stripe of 2^stripe_shift_ rows
    std::vector<std::uint8_t> ever_touched_;  // [channel]
    std::vector<RowState> row_states_;        // [channel * row_capacity_ + row]
    std::vector<CameraRow> camera_rows_;
    std::vector<std::int32_t> originals_;
    std::vector<ExtraRowsOfRay> extra_rows_;  // [camera row]
    std::size_t row_capacity_ = 0;
    int max_rows_ = 0, camera_row_count_ = 0, row_count_ = 0, stripe_shift_ = 0;
    bool discarded_ = false, handed_on_ = false;
};

}  // namespace raylex::display
