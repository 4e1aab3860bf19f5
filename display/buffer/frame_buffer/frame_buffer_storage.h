// Private to the frame buffer: how its record lies in memory.
#pragma once

#include "display/buffer/fixed_point.h"
#include "display/buffer/frame_buffer/frame_buffer.h"
#include "display/buffer/pixel_filter.h"
#include "display/buffer/plane.h"
#include "display/buffer/ray_rows.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdlib>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace raylex::display {

/// What a batch is worked out into before it is summed up. Scratch of one thread.
struct BatchScratch {
    RayRows rays;
    std::vector<double> folded;            // one channel's samples, each of all rows of its ray
    std::vector<double> weights;           // [camera row]
    std::vector<int> block_ends, nearest;  // of one run
};

/// What each sample of a run counts for in the pixels around it, in splat mode. Scratch of one thread.
struct SplatWeights {
    std::vector<std::size_t> pixels;  // in reach: [target]
    std::vector<double> weights;      // [target * count + row of the run]
    std::size_t count = 0;            // rows of the run

    void gather(const SampleTable& table, const PixelFilter& kernel, const FrameBufferLayout& layout, int begin,
                int end);
    [[nodiscard]] const double* of(std::size_t target) const { return weights.data() + target * count; }
};

/// One run's sums of the channels that sets stand for, in fixed point: the order of sets, which is that of their coming
/// up in the batch, does not show. What is added is below 2^110 a set and block, and of those there are far fewer than
/// 2^16 with something in them, so none overflows. Scratch of one thread.
struct SetSums {
    using Sum = std::array<Int128, 3>;
    std::vector<Sum> sums;                // [channel] 0 between runs
    std::vector<std::uint8_t> taken;      // [channel] 0 between runs
    std::vector<std::uint32_t> channels;  // taken
    /// What the run before came to. Its memory was asked for then and has had the time of this run to come.
    struct Addend {
        std::uint32_t channel;
        Sum sum;
    };
    std::vector<Addend> waiting;
    std::size_t waiting_pixel = 0;
};

/// Camera rows of one pixel that stand together: one block or, in importance mode, as many as there are. Doubles are
/// summed within a block alone; the blocks' sums are exact, so they go to memory, which is slow to reach, as one.
struct FrameBuffer::Run {
    static constexpr std::size_t most_blocks = 64;  // of sums that cannot overflow: see FixedSum and SetSums
    static constexpr std::size_t no_pixel = ~std::size_t{0};
    std::size_t pixel = 0;
    std::size_t next_pixel = no_pixel;    // the next run's, where there is one
    bool inside = true;                   // the image; splat mode takes samples from around it too
    int begin = 0, end = 0;               // camera rows
    std::span<const int> block_ends;      // where its blocks end, in order; the last is `end`
    const SplatWeights* splat = nullptr;  // null in importance mode
    const RayRows* rays = nullptr;
    std::vector<double>* scratch = nullptr;
    SetSums* set_sums = nullptr;
    std::span<const double> alpha;        // [camera row]
    const double* weights = nullptr;      // [row of the run]
    bool unit_weights = false;            // all of them 1, as a filter's are whose samples are drawn by it
    std::vector<int>* nearest = nullptr;  // [block] camera row, negative until somebody asks; without extra rows alone

    /// What weighted_sum() takes, from a camera row on.
    [[nodiscard]] const double* sum_weights(int row) const { return unit_weights ? nullptr : weights + (row - begin); }
    template <class Visit>
    void for_each_row(Visit visit) const {
        for_each_row(begin, end, visit);
    }
    template <class Visit>
    void for_each_row(int first, int last, Visit visit) const {
        for (int row = first; row < last; ++row) {
            for (const int r : rays->of(row)) visit(r);
        }
    }
    /// visit(first camera row, one past the last, number of the block).
    template <class Visit>
    void for_each_block(Visit visit) const {
        int first = begin;
        for (std::size_t block = 0; block < block_ends.size(); ++block)
            visit(std::exchange(first, block_ends[block]), block_ends[block], block);
    }
};

/// The record of one channel. Planes that its rule does not need stay empty.
struct FrameBuffer::Channel {
    ChannelDefinition definition;
    ChannelId samples_of = invalid_channel;  // whose samples it takes in: its own, or its source's
    int components = 1;
    Plane<Int128> sum;                // [pixel, component] filter: weighted; average, sum: unweighted
    Plane<Int128> raster_sum;         // [pixel, component] raster splats: by the kernel
    Plane<Int128> plain_sum;          // [pixel, component] statistics: unweighted
    Plane<Int128> square_sum;         // [pixel, component] statistics: squares, quantum 2^square_exponent()
    Plane<Int128> even_sum, odd_sum;  // [pixel, component] half buffers: weighted, of the samples of that parity
    Plane<double> picked;             // [pixel, component] zmin, zmax, min, max
    Plane<float> depth;               // [pixel] zmin, zmax: of the row picked
    Plane<std::uint64_t> seen;        // [pixel] zmin, zmax: sample index picked + 1; else: rows taken in

    /// The one list of what is kept per channel: calls visit("name", pointer to member) for each plane, empty ones too.
    /// Whoever saves, loads or merges a record goes by it.
    template <class Visit>
    static void for_each_plane(Visit visit) {
        visit("sum", &Channel::sum);
        visit("raster_sum", &Channel::raster_sum);
        visit("plain_sum", &Channel::plain_sum);
        visit("square_sum", &Channel::square_sum);
        visit("even_sum", &Channel::even_sum);
        visit("odd_sum", &Channel::odd_sum);
        visit("picked", &Channel::picked);
        visit("depth", &Channel::depth);
        visit("seen", &Channel::seen);
    }
};

struct FrameBuffer::Storage {
    // Squares need more room upwards (2^71) and less below than values do.
    static constexpr int unscaled_square_exponent = -56;

    FrameBufferLayout layout;
    std::optional<PixelFilter> kernel;            // splat mode
    std::optional<PixelFilter> raster_kernel;     // raster splats
    std::string kernel_name, raster_kernel_name;  // empty without; of a record, all that there is
    std::vector<std::size_t> raster_channels;     // which have a raster_sum
    std::vector<ChannelDefinition> definitions;
    std::vector<Channel> channels;
    /// The channels that take samples in, close together: every run of samples goes through all of them, and most of
    /// many channels get nothing from it.
    struct Accumulator {
        std::uint32_t channel, from;  // whose samples
        bool reads_untouched;         // whether samples of which nothing was sent to it still change it
        bool sums_only;               // whether a block's weighted sum is all that is kept of it, in importance mode
        bool plain;                   // of a channel that values are written to
        std::uint32_t components;
        /// What of the channel a run of samples reaches: null where it keeps none.
        struct Place {
            const char* first = nullptr;
            std::uint32_t pixel_bytes = 0;
        };
        std::array<Place, 3> places;
    };
    std::vector<Accumulator> accumulators;  // those of channels that sets stand for come last
    std::size_t own_accumulators = 0;       // the others
    std::vector<Int128*> sum_of;            // [channel] null where its rule keeps none
    std::vector<int> exponents;             // [channel] of its sums' quantum; the last entry for weight and alpha
    Plane<std::uint64_t> samples;           // [pixel]
    Plane<Int128> weight, alpha;            // [pixel] sums of weight, weight x alpha
    Plane<Int128> weight_square;            // [pixel] only when a channel keeps statistics
    Plane<std::uint64_t> even_samples, odd_samples;  // [pixel] only when a channel keeps half buffers
    Plane<Int128> even_weight, odd_weight;
    Plane<std::uint64_t> light_paths;                        // one number: how many the raster splats are of
    std::unique_ptr<std::atomic<std::uint64_t>[]> rejected;  // [channel], the last entry for weight and alpha
    std::atomic<double> largest_light{0};  // |weight x value| of a sample, of filters with negative lobes alone

    void note_light(double magnitude) {
        for (double known = largest_light.load(); magnitude > known;)
            if (largest_light.compare_exchange_weak(known, magnitude)) return;
    }
    void note_lights(const SampleTable& table, std::span<const double> weights);

    /// The same list for what all channels share.
    template <class Visit>
    static void for_each_plane(Visit visit) {
        visit("samples", &Storage::samples);
        visit("weight", &Storage::weight);
        visit("alpha", &Storage::alpha);
        visit("weight_square", &Storage::weight_square);
        visit("even_samples", &Storage::even_samples);
        visit("odd_samples", &Storage::odd_samples);
        visit("even_weight", &Storage::even_weight);
        visit("odd_weight", &Storage::odd_weight);
        visit("light_paths", &Storage::light_paths);
    }

    void set_kernel(const PixelFilter& filter) {
        kernel = filter;
        kernel_name = filter.name();
    }
    void set_raster_kernel(const PixelFilter& filter) {
        raster_kernel = filter;
        raster_kernel_name = filter.name();
    }
    /// What every run of a pixel reaches, so that it is there in time.
    void prefetch(std::size_t pixel) {
        __builtin_prefetch(&samples[pixel], 1);
        __builtin_prefetch(&weight[pixel], 1);
        __builtin_prefetch(&alpha[pixel], 1);
        if (!weight_square.empty()) __builtin_prefetch(&weight_square[pixel], 1);
    }
    /// What makes a pixel of a raster sum; 0 before there are light paths.
    /// What raster sums in quanta of the weights' size are multiplied by.
    [[nodiscard]] long double raster_scale() const;
    [[nodiscard]] static int square_exponent(const Channel& channel) {
        return unscaled_square_exponent + 2 * channel.definition.scale_exponent;
    }
    void reject(std::size_t channel) { rejected[channel].fetch_add(1, std::memory_order_relaxed); }
    /// sum[at ..] += the terms, all of them or (counted against `channel`) none.
    void add(Plane<Int128>& sum, std::size_t at, const double* terms, int count, int exponent, std::size_t channel) {
        const bool fits =
            count == 3 ? add_terms<3>(&sum[at], terms, exponent) : add_terms<1>(&sum[at], terms, exponent);
        if (!fits) reject(channel);
    }
    /// All or, where one would not fit, none and false.
    template <std::size_t count>
    [[nodiscard]] static bool add_terms(Int128* to, const double* terms, int exponent) {
        Int128 result[count];
        bool fits = true;
        for (std::size_t c = 0; c < count; ++c) {
            Int128 term = 0;
            fits = to_fixed(terms[c], exponent, term) && fits;
            result[c] = to[c];
            fits = add_fixed(result[c], term) && fits;
        }
        if (fits)
            for (std::size_t c = 0; c < count; ++c) to[c] = result[c];
        return fits;
    }
    /// to[..] += the total of several blocks: all of it or, where it does not fit, none and false. A total of nothing
    /// is not added, so that its memory page is not needed either.
    template <std::size_t count>
    [[nodiscard]] static bool add_total(Int128* to, const std::array<Int128, count>& total) {
        Int128 any = 0;
        for (const Int128 each : total) any |= each;
        if (any == 0) return true;
        bool fits = true;
        for (std::size_t c = 0; c < count; ++c) {
            Int128 ignored;  // a sum that were kept would be copied in other pieces than it was made in: much slower
            fits &= !__builtin_add_overflow(to[c], total[c], &ignored);
        }
        if (!fits) [[unlikely]]
            return false;
        for (std::size_t c = 0; c < count; ++c) to[c] += total[c];
        return true;
    }
    /// to[..] += one block's sums, counted against `channel` where they do not fit.
    template <std::size_t count>
    [[gnu::noinline]] void add_block(Int128* to, const std::array<double, count>& sum, int exponent,
                                     std::size_t channel) {
        if (!add_terms<count>(to, sum.data(), exponent)) reject(channel);
    }
    /// to[..] += terms of every block of the run: `terms(add, first row, one past the last, block)` calls add(sums) for
    /// each, the same ones whenever it is called. What does not fit is counted against `channel`, block by block.
    template <std::size_t count, class Terms>
    void add_each(Int128* to, const Run& run, int exponent, std::size_t channel, Terms terms) {
        using Sums = std::array<double, count>;
        FixedSum<count> total(exponent);
        const auto add = [&](const Sums& sums) {
            if (!total.add(sums)) [[unlikely]]
                add_block(to, sums, exponent, channel);
        };
        run.for_each_block([&](int first, int last, std::size_t block) { terms(add, first, last, block); });
        if (add_total<count>(to, total.total())) [[likely]]
            return;
        const auto add_again = [&](const Sums& sums) {
            if (FixedSum<count>(exponent).add(sums)) add_block(to, sums, exponent, channel);
        };
        run.for_each_block([&](int first, int last, std::size_t block) { terms(add_again, first, last, block); });
    }
    /// The same of one array of sums a block: term(first row, one past the last), without other effects.
    template <std::size_t count, class Term>
    void add_blocks(Int128* to, const Run& run, int exponent, std::size_t channel, Term term) {
        add_each<count>(to, run, exponent, channel,
                        [&](auto add, int first, int last, std::size_t) { add(term(first, last)); });
    }
    void add_sets(const SampleTable& table, const Run& run);
    void add_set(const SampleTable& table, const Run& run, std::size_t place, std::span<const ChannelId> set);
    void add_waiting(SetSums& sums);
    template <std::size_t components>
    void add_sum(const Accumulator& accumulator, const SampleTable& table, const Run& run);
    template <std::size_t components>
    void add_moments(Channel& channel, std::size_t index, const Run& run, const double* values);
    void splat_weights(const Run& run);
    void splat_values(Channel& channel, std::size_t index, const Run& run, const double* values);
    void add_filtered(Channel& channel, std::size_t index, const SampleTable& table, const Run& run);
    void add_halves(Channel& channel, std::size_t index, const SampleTable& table, const Run& run,
                    const double* values);
    void add_half_weights(const SampleTable& table, const Run& run);
    [[nodiscard]] std::vector<double> statistic(const Channel& source, Statistic statistic,
                                                const PixelRegion& region) const;
    void add_plain(Channel& channel, std::size_t index, const SampleTable& table, const Run& run);
    void add_picked(Channel& channel, std::size_t index, const SampleTable& table, const Run& run);
    void merge_picked(Channel& to, const Channel& from) const;
    [[nodiscard]] std::size_t pixel_count() const {
        return static_cast<std::size_t>(layout.width) * static_cast<std::size_t>(layout.height);
    }
};

/// What a channel keeps beside its value, for itself or for a layer of statistics made of it.
struct KeptStatistics {
    bool moments = false;  // plain_sum and square_sum
    bool halves = false;   // even_sum and odd_sum
};
[[nodiscard]] inline KeptStatistics kept_statistics(std::span<const ChannelDefinition> channels, std::size_t index) {
    KeptStatistics kept;
    if (channels[index].rule != FilterRule::filter || !takes_samples(channels[index])) return kept;
    kept.moments = channels[index].statistics;
    for (const ChannelDefinition& layer : channels) {
        if (keeps_pixels(layer) || layer.source != static_cast<ChannelId>(index)) continue;
        const bool half = layer.statistic == Statistic::even || layer.statistic == Statistic::odd;
        (half ? kept.halves : kept.moments) = true;
    }
    return kept;
}

/// The sum of weight x value over rows; without weights, of the values: the same bits as with weights of 1. Even and
/// odd rows make sums of their own, so that two numbers are added at once.
template <std::size_t components>
[[nodiscard]] inline std::array<double, components> weighted_sum(const double* values, const double* weights,
                                                                 std::size_t rows) {
    double sums[2 * components] = {};
    const std::size_t pairs = rows / 2;
    if (weights == nullptr) {
        for (std::size_t i = 0; i < pairs; ++i)
            for (std::size_t k = 0; k < 2 * components; ++k) sums[k] += values[2 * components * i + k];
        if (rows % 2 != 0)
            for (std::size_t c = 0; c < components; ++c) sums[c] += values[2 * components * pairs + c];
    } else {
        for (std::size_t i = 0; i < pairs; ++i)
            for (std::size_t k = 0; k < 2 * components; ++k)
                sums[k] += weights[2 * i + (k < components ? 0 : 1)] * values[2 * components * i + k];
        if (rows % 2 != 0)
            for (std::size_t c = 0; c < components; ++c)
                sums[c] += weights[rows - 1] * values[2 * components * pairs + c];
    }
    std::array<double, components> sum;
    for (std::size_t c = 0; c < components; ++c) sum[c] = sums[c] + sums[components + c];
    return sum;
}

/// Calls visit(index in the region, index in the image) for each pixel, row by row.
template <class Visit>
void for_each_pixel(const PixelRegion& region, int width, Visit visit) {
    std::size_t at = 0;
    for (int y = region.y0; y < region.y1; ++y) {
        std::size_t pixel =
            static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(region.x0);
        for (int x = region.x0; x < region.x1; ++x) visit(at++, pixel++);
    }
}

[[nodiscard]] inline std::size_t pixel_count(const PixelRegion& region) {
    return static_cast<std::size_t>(region.width()) * static_cast<std::size_t>(region.height());
}

/// What sums of one pixel are divided by, all in quanta. A pixel whose weights cancel is divided by its sample count:
/// weights have mean 1. The reciprocal costs at most 1.5 units in the last of 64 bits before rounding to 53, so a mean
/// of equal values is that value.
struct Divisor {
    long double reciprocal = 0;
    std::uint64_t samples = 0;
    int exponent = 0;
    long double scale = 1;  // a power of two: products with it are exact

    /// `quantum_exponent` is of the weights, `scale_exponent` what the sums' own is more.
    Divisor(Int128 weight_sum, std::uint64_t sample_count, int quantum_exponent, int scale_exponent = 0)
        : samples(sample_count), exponent(quantum_exponent), scale(power_of_two(scale_exponent)) {
        if (weight_sum != 0) reciprocal = 1.0L / as_long_double(weight_sum) * scale;
    }
    [[nodiscard]] double mean_of(Int128 sum) const {
        if (sum == 0) return 0;
        if (reciprocal != 0) return static_cast<double>(as_long_double(sum) * reciprocal);
        if (samples == 0) return 0;
        return static_cast<double>(to_long_double(sum, exponent) * scale / static_cast<long double>(samples));
    }
};

[[nodiscard]] inline bool is_z_rule(FilterRule rule) {
    return rule == FilterRule::zmin || rule == FilterRule::zmax;
}
[[nodiscard]] inline bool is_extremum(FilterRule rule) {
    return rule == FilterRule::min || rule == FilterRule::max;
}

/// Whether (depth, sample) beats what a z rule has picked so far.
inline bool z_rule_prefers(FilterRule rule, float depth, std::uint64_t sample, float best_depth,
                           std::uint64_t best_seen) {
    if (best_seen == 0) return true;
    if (depth != best_depth) return rule == FilterRule::zmin ? depth < best_depth : depth > best_depth;
    return sample + 1 < best_seen;
}

/// The smaller or larger of two values; +0 stands for both zeros, so that no order of merging shows.
[[nodiscard]] inline double pick_extremum(FilterRule rule, bool first, double best, double value) {
    value += 0.0;
    if (first) return value;
    return rule == FilterRule::min ? std::min(best, value) : std::max(best, value);
}

}  // namespace raylex::display
