// Private to the frame buffer: the layout of its record in memory.
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

/// Intermediate values of a batch before it is summed. Scratch memory of one thread.
struct BatchScratch {
    RayRows rays;
    std::vector<double> folded;            // samples of one channel, each over all rows of its ray
    std::vector<double> weights;           // [camera row]
    std::vector<int> block_ends, nearest;  // for one run
};

/// Splat mode: the weights of a run's samples for the pixels around it. Scratch memory of one thread.
struct SplatWeights {
    std::vector<std::size_t> pixels;  // pixels in reach: [target]
    std::vector<double> weights;      // [target * count + row of the run]
    std::size_t count = 0;            // number of rows of the run

    void gather(const SampleTable& table, const PixelFilter& kernel, const FrameBufferLayout& layout, int begin,
                int end);
    [[nodiscard]] const double* of(std::size_t target) const { return weights.data() + target * count; }
};

/// Sums of one run for the channels that sets represent, in fixed point, so the order of the sets does not matter. Each
/// set and block adds less than 2^110, and there are far fewer than 2^16 non-empty ones, so nothing overflows. Scratch
/// memory of one thread.
struct SetSums {
    using Sum = std::array<Int128, 3>;
    std::vector<Sum> sums;                // [channel] 0 between runs
    std::vector<std::uint8_t> taken;      // [channel] 0 between runs
    std::vector<std::uint32_t> channels;  // channels that were used
    /// Totals of the previous run. Their memory was prefetched then, and arrives during the current run.
    struct Addend {
        std::uint32_t channel;
        Sum sum;
    };
    std::vector<Addend> waiting;
    std::size_t waiting_pixel = 0;
};

/// Consecutive camera rows of one pixel: one block or, in importance mode, all of its blocks. Doubles are summed only
/// within a block. Block sums are exact, so all blocks go to memory, which is slow, in one addition.
struct FrameBuffer::Run {
    static constexpr std::size_t most_blocks = 64;  // blocks whose sums cannot overflow: see FixedSum and SetSums
    static constexpr std::size_t no_pixel = ~std::size_t{0};
    std::size_t pixel = 0;
    std::size_t next_pixel = no_pixel;    // pixel of the next run, if there is one
    bool inside = true;                   // in the image; splat mode also takes samples around it
    int begin = 0, end = 0;               // camera rows
    std::span<const int> block_ends;      // ends of its blocks, in order; the last is `end`
    const SplatWeights* splat = nullptr;  // null in importance mode
    const RayRows* rays = nullptr;
    std::vector<double>* scratch = nullptr;
    SetSums* set_sums = nullptr;
    std::span<const double> alpha;        // [camera row]
    const double* weights = nullptr;      // [row of the run]
    bool unit_weights = false;            // all weights are 1, as for a filter that draws its samples
    std::vector<int>* nearest = nullptr;  // [block] camera row, negative until computed; only without extra rows

    /// Weights for weighted_sum() from a camera row on; null if all are 1.
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
    /// Calls visit(first camera row, one past the last, number of the block) for each block.
    template <class Visit>
    void for_each_block(Visit visit) const {
        int first = begin;
        for (std::size_t block = 0; block < block_ends.size(); ++block)
            visit(std::exchange(first, block_ends[block]), block_ends[block], block);
    }
};

/// The record of one channel. Planes that its rule does not use stay empty.
struct FrameBuffer::Channel {
    ChannelDefinition definition;
    ChannelId samples_of = invalid_channel;  // the channel whose samples it adds: itself, or its source
    int components = 1;
    Plane<Int128> sum;                // [pixel, component] filter: weighted; average, sum: unweighted
    Plane<Int128> raster_sum;         // [pixel, component] raster splats, weighted by the kernel
    Plane<Int128> plain_sum;          // [pixel, component] statistics: unweighted
    Plane<Int128> square_sum;         // [pixel, component] statistics: squares, quantum 2^square_exponent()
    Plane<Int128> even_sum, odd_sum;  // [pixel, component] half buffers: weighted sums of even and odd samples
    Plane<double> picked;             // [pixel, component] zmin, zmax, min, max
    Plane<float> depth;               // [pixel] zmin, zmax: depth of the picked row
    Plane<std::uint64_t> seen;        // [pixel] zmin, zmax: picked sample index + 1; else: number of rows

    /// The only list of planes per channel: calls visit("name", pointer to member) for each plane, including empty
    /// ones. Saving, loading and merging use it.
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
    // Squares need more range upwards (2^71) and less precision below than values.
    static constexpr int unscaled_square_exponent = -56;

    FrameBufferLayout layout;
    std::optional<PixelFilter> kernel;            // splat mode
    std::optional<PixelFilter> raster_kernel;     // raster splats
    std::string kernel_name, raster_kernel_name;  // empty without kernels; records contain only the names
    std::vector<std::size_t> raster_channels;     // channels that have a raster_sum
    std::vector<ChannelDefinition> definitions;
    std::vector<Channel> channels;
    /// The channels that take samples, stored compactly: every run visits all of them, and usually most get nothing.
    struct Accumulator {
        std::uint32_t channel, from;  // from: the channel whose samples it takes
        bool reads_untouched;         // untouched samples change it, too
        bool sums_only;               // importance mode: it keeps only the weighted sum of each block
        bool plain;                   // a channel that values are written to
        std::uint32_t components;
        /// The memory of the channel that a run writes to; null where it keeps none.
        struct Place {
            const char* first = nullptr;
            std::uint32_t pixel_bytes = 0;
        };
        std::array<Place, 3> places;
    };
    std::vector<Accumulator> accumulators;  // channels that sets represent come last
    std::size_t own_accumulators = 0;       // number of accumulators without sets
    std::vector<Int128*> sum_of;            // [channel] null if its rule keeps no sum
    std::vector<int> exponents;             // [channel] exponent of its quantum; the last entry is for weight and alpha
    Plane<std::uint64_t> samples;           // [pixel]
    Plane<Int128> weight, alpha;            // [pixel] sums of weight, weight x alpha
    Plane<Int128> weight_square;            // [pixel] only if a channel keeps statistics
    Plane<std::uint64_t> even_samples, odd_samples;  // [pixel] only if a channel keeps half buffers
    Plane<Int128> even_weight, odd_weight;
    Plane<std::uint64_t> light_paths;                        // one number: the light paths of the raster splats
    std::unique_ptr<std::atomic<std::uint64_t>[]> rejected;  // [channel]; the last entry is for weight and alpha
    std::atomic<double> largest_light{0};  // |weight x value| of a sample, only for filters with negative lobes

    void note_light(double magnitude) {
        for (double known = largest_light.load(); magnitude > known;)
            if (largest_light.compare_exchange_weak(known, magnitude)) return;
    }
    void note_lights(const SampleTable& table, std::span<const double> weights);

    /// The list of planes that all channels share.
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

    // Planes of a channel that keeps variances, and of one that keeps even and odd halves.
    void allocate_moments(Channel& channel, std::size_t values);
    void allocate_halves(Channel& channel, std::size_t values);

    void set_kernel(const PixelFilter& filter) {
        kernel = filter;
        kernel_name = filter.name();
    }
    void set_raster_kernel(const PixelFilter& filter) {
        raster_kernel = filter;
        raster_kernel_name = filter.name();
    }
    /// Prefetches the memory that every run of a pixel uses.
    void prefetch(std::size_t pixel) {
        __builtin_prefetch(&samples[pixel], 1);
        __builtin_prefetch(&weight[pixel], 1);
        __builtin_prefetch(&alpha[pixel], 1);
        if (!weight_square.empty()) __builtin_prefetch(&weight_square[pixel], 1);
    }
    /// The factor from raster sums, in quanta of the weights' size, to pixel values; 0 before there are light paths.
    [[nodiscard]] long double raster_scale() const;
    [[nodiscard]] static int square_exponent(const Channel& channel) {
        return unscaled_square_exponent + 2 * channel.definition.scale_exponent;
    }
    void reject(std::size_t channel) { rejected[channel].fetch_add(1, std::memory_order_relaxed); }
    /// Adds the terms to sum[at ..]: all of them, or none if one does not fit, which is counted against `channel`.
    void add(Plane<Int128>& sum, std::size_t at, const double* terms, int count, int exponent, std::size_t channel) {
        const bool fits =
            count == 3 ? add_terms<3>(&sum[at], terms, exponent) : add_terms<1>(&sum[at], terms, exponent);
        if (!fits) reject(channel);
    }
    /// Adds all terms, or none if one would not fit; then returns false.
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
    /// Adds the total of several blocks, or nothing if it does not fit; then returns false. A total of 0 is not added,
    /// so its memory page is not needed.
    template <std::size_t count>
    [[nodiscard]] static bool add_total(Int128* to, const std::array<Int128, count>& total) {
        Int128 any = 0;
        for (const Int128 each : total) any |= each;
        if (any == 0) return true;
        bool fits = true;
        for (std::size_t c = 0; c < count; ++c) {
            Int128 ignored;  // keeping the sums would copy them in other pieces than they were made in, which is much
                             // slower
            fits &= !__builtin_add_overflow(to[c], total[c], &ignored);
        }
        if (!fits) [[unlikely]]
            return false;
        for (std::size_t c = 0; c < count; ++c) to[c] += total[c];
        return true;
    }
    /// Adds the sums of one block; counts a sum that does not fit against `channel`.
    template <std::size_t count>
    [[gnu::noinline]] void add_block(Int128* to, const std::array<double, count>& sum, int exponent,
                                     std::size_t channel) {
        if (!add_terms<count>(to, sum.data(), exponent)) reject(channel);
    }
    /// Adds the terms of every block of the run. `terms(add, first row, one past the last, block)` calls add(sums) for
    /// each, with equal sums whenever it is called. A sum that does not fit is counted against `channel`, block by
    /// block.
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
    /// Adds one array of sums per block: term(first row, one past the last), which must have no side effects.
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

/// The sums that a channel keeps beside its value, for itself or for a layer of statistics.
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

/// The sum of weight x value over rows. Without weights it sums the values, with the same bits as weights of 1. Even
/// and odd rows have separate sums, so that two numbers are added at once.
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

/// The divisor of one pixel's sums, in quanta. A pixel whose weights cancel is divided by its sample count, because
/// weights have mean 1. The reciprocal adds an error of at most 1.5 units in the last of 64 bits before rounding to 53,
/// so the mean of equal values is that value.
struct Divisor {
    long double reciprocal = 0;
    std::uint64_t samples = 0;
    int exponent = 0;
    long double scale = 1;  // a power of two: products with it are exact

    /// `quantum_exponent` is that of the weights; that of the sums is larger by `scale_exponent`.
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

/// Returns whether a z rule prefers (depth, sample) to its current pick.
inline bool z_rule_prefers(FilterRule rule, float depth, std::uint64_t sample, float best_depth,
                           std::uint64_t best_seen) {
    if (best_seen == 0) return true;
    if (depth != best_depth) return rule == FilterRule::zmin ? depth < best_depth : depth > best_depth;
    return sample + 1 < best_seen;
}

/// The smaller or larger of two values. Both zeros become +0, so that the order of merging does not matter.
[[nodiscard]] inline double pick_extremum(FilterRule rule, bool first, double best, double value) {
    value += 0.0;
    if (first) return value;
    return rule == FilterRule::min ? std::min(best, value) : std::max(best, value);
}

}  // namespace raylex::display
