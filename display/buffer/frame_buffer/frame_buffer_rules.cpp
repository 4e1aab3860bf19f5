// Adds one run of samples to the record of one channel, according to its rule.
#include "display/buffer/frame_buffer/frame_buffer_storage.h"

#include <array>
#include <cmath>

namespace raylex::display {
namespace {

using RowState = SampleTable::RowState;

/// The filtered value of one camera sample: see ray_rows.h. Misses have the miss value if it is finite.
void fold_sample(const SampleTable& table, ChannelId id, int components, int row, const RayRows& rays, double* out) {
    const std::span<const int> rows = rays.of(row);
    const bool plain = table.channel(id).style == ChannelStyle::name;
    const double fill = table.fill_value(id);
    std::fill_n(out, components, 0.0);
    for (const int r : rows) {
        const RowState state = plain ? table.row_state(id, r) : RowState::splatted;
        // LPE services leave the rows of a plain beauty untouched; a row with a miss value counts below.
        if (state == RowState::written || (state == RowState::untouched && fill != 0)) continue;
        const double* v = table.values(id) + static_cast<std::size_t>(r) * static_cast<std::size_t>(components);
        for (int c = 0; c < components; ++c) out[c] += v[c];
    }
    if (!plain) return;
    const WrittenMean mean = written_mean(table, id, rows, rays.coverage(row));
    if (mean.any) {
        const double alpha = rays.alpha()[static_cast<std::size_t>(row)];
        for (int c = 0; c < components; ++c)
            out[c] += (alpha > 0 ? alpha : 1.0) * mean.value[static_cast<std::size_t>(c)];
    }
    if (!mean.set && fill != 0 && std::isfinite(fill)) std::fill_n(out, components, fill);
}

/// Sums over the rows of a block: the values, and their squared deviations from the block's mean.
template <std::size_t components>
void sum_block(std::size_t rows, const double* values, std::array<double, components>& plain,
               std::array<double, components>& square) {
    plain = square = {};
    const double* v = values;
    for (std::size_t row = 0; row < rows; ++row, v += components)
        for (std::size_t c = 0; c < components; ++c) plain[c] += v[c];
    const auto count = static_cast<double>(rows);
    std::array<double, components> mean;
    for (std::size_t c = 0; c < components; ++c) mean[c] = plain[c] / count;
    v = values;
    for (std::size_t row = 0; row < rows; ++row, v += components)
        for (std::size_t c = 0; c < components; ++c) {
            const double deviation = v[c] - mean[c];
            square[c] += deviation * deviation;
        }
}

/// plain^2 / count in twice the precision of double, as high + low.
void mean_part(double plain, double count, double& high, double& low) {
    const double square = plain * plain, square_error = std::fma(plain, plain, -square);
    high = square / count;
    low = (std::fma(-high, count, square) + square_error) / count;
}

/// The first of the camera rows with the smallest depth; samples of a block are in ascending order.
int nearest_row(const SampleTable& table, int begin, int end) {
    const float* const depth = table.depth.data();
    float least = depth[begin];
    for (int row = begin + 1; row < end; ++row) least = depth[row] < least ? depth[row] : least;
    int row = begin;
    while (row + 1 < end && !(depth[row] <= least)) ++row;
    return row;
}

/// Returns whether a rule uses this row: every row of an expression channel, and the written rows of a plain one.
bool counts(const SampleTable& table, ChannelId id, int row) {
    return table.channel(id).style == ChannelStyle::expression || table.written(id, row);
}

}  // namespace

void FrameBuffer::Storage::add_filtered(Channel& channel, std::size_t index, const SampleTable& table, const Run& run) {
    const auto id = static_cast<ChannelId>(index);
    const auto components = static_cast<std::size_t>(channel.components);
    const double* values = table.values(id) + static_cast<std::size_t>(run.begin) * components;
    const bool fold =
        run.rays->any_extra() || (channel.definition.style == ChannelStyle::name &&
                                  (run.rays->any_partial() || !std::isfinite(channel.definition.miss_value)));
    if (fold) {
        std::vector<double>& scratch = *run.scratch;
        scratch.resize(static_cast<std::size_t>(run.end - run.begin) * components);
        for (int row = run.begin; row < run.end; ++row)
            fold_sample(table, id, channel.components, row, *run.rays,
                        &scratch[static_cast<std::size_t>(row - run.begin) * components]);
        values = scratch.data();
    }
    if (run.splat != nullptr) return splat_values(channel, index, run, values);
    if (!channel.even_sum.empty()) add_halves(channel, index, table, run, values);
    const auto add = [&]<std::size_t count>() {
        add_blocks<count>(&channel.sum[run.pixel * count], run, exponents[index], index, [&](int first, int last) {
            return weighted_sum<count>(values + static_cast<std::size_t>(first - run.begin) * count,
                                       run.sum_weights(first), static_cast<std::size_t>(last - first));
        });
        if (!channel.square_sum.empty()) add_moments<count>(channel, index, run, values);
    };
    if (components == 3) add.template operator()<3>();
    else add.template operator()<1>();
}

/// `values` begin at the run's first row. A block adds the squares about its mean plus the part of the mean, which
/// preserves the digits of the deviations.
template <std::size_t components>
void FrameBuffer::Storage::add_moments(Channel& channel, std::size_t index, const Run& run, const double* values) {
    std::array<std::array<double, components>, Run::most_blocks> plain, square;
    run.for_each_block([&](int first, int last, std::size_t block) {
        sum_block<components>(static_cast<std::size_t>(last - first),
                              values + static_cast<std::size_t>(first - run.begin) * components, plain[block],
                              square[block]);
    });
    add_each<components>(&channel.plain_sum[run.pixel * components], run, exponents[index], index,
                         [&](auto add, int, int, std::size_t block) { add(plain[block]); });
    add_each<components>(&channel.square_sum[run.pixel * components], run, square_exponent(channel), index,
                         [&](auto add, int first, int last, std::size_t block) {
                             std::array<double, components> high, low;
                             for (std::size_t c = 0; c < components; ++c)
                                 mean_part(plain[block][c], last - first, high[c], low[c]);
                             add(square[block]);
                             add(high);
                             add(low);
                         });
}

void FrameBuffer::Storage::add_plain(Channel& channel, std::size_t index, const SampleTable& table, const Run& run) {
    const auto id = static_cast<ChannelId>(index);
    const auto add = [&]<std::size_t count>() {
        add_blocks<count>(&channel.sum[run.pixel * count], run, exponents[index], index, [&](int first, int last) {
            std::array<double, count> sum{};
            run.for_each_row(first, last, [&](int row) {
                if (!counts(table, id, row)) return;
                for (std::size_t c = 0; c < count; ++c)
                    sum[c] += table.values(id)[static_cast<std::size_t>(row) * count + c];
            });
            return sum;
        });
    };
    if (channel.components == 3) add.template operator()<3>();
    else add.template operator()<1>();
    run.for_each_row([&](int row) { channel.seen[run.pixel] += counts(table, id, row) ? 1 : 0; });
}

void FrameBuffer::Storage::add_picked(Channel& channel, std::size_t index, const SampleTable& table, const Run& run) {
    const auto id = static_cast<ChannelId>(index);
    const auto components = static_cast<std::size_t>(channel.components);
    const FilterRule rule = channel.definition.rule;
    const auto value = [&](int row) { return table.values(id) + static_cast<std::size_t>(row) * components; };
    const auto takes = [&](int row) {
        if (!counts(table, id, row)) return false;
        const double* v = value(row);
        bool finite = std::isfinite(v[0]);
        for (std::size_t c = 1; c < components; ++c) finite = finite && std::isfinite(v[c]);
        if (!finite) reject(index);
        return finite;
    };
    std::uint64_t& seen = channel.seen[run.pixel];
    double* const best = &channel.picked[run.pixel * components];
    if (is_extremum(rule)) {
        run.for_each_row([&](int row) {
            if (!takes(row)) return;
            for (std::size_t c = 0; c < components; ++c)
                best[c] = pick_extremum(rule, seen == 0, best[c], value(row)[c]);
            ++seen;
        });
        return;
    }
    // Each block picks a row first, because access to the record is slow. If the nearest sample over all channels
    // counts here, which is usual, the others need not be tested.
    run.for_each_block([&](int first, int last, std::size_t block) {
        int picked = -1;
        float depth = 0;
        std::uint64_t of_sample = 0;
        if (rule == FilterRule::zmin && !run.rays->any_extra()) {
            int& nearest = (*run.nearest)[block];
            if (nearest < 0) nearest = nearest_row(table, first, last);
            if (counts(table, id, nearest) && takes(nearest)) {
                picked = nearest;
                depth = table.depth[static_cast<std::size_t>(picked)];
                of_sample = table.camera_row(picked).sample + 1;
            }
        }
        if (picked < 0)
            run.for_each_row(first, last, [&](int row) {
                const float here = table.depth[static_cast<std::size_t>(row)];
                const std::uint64_t sample = table.camera_row(row).sample;
                if (!takes(row) || !z_rule_prefers(rule, here, sample, depth, of_sample)) return;
                picked = row;
                depth = here;
                of_sample = sample + 1;
            });
        if (picked < 0 || !z_rule_prefers(rule, depth, of_sample - 1, channel.depth[run.pixel], seen)) return;
        std::copy_n(value(picked), components, best);
        channel.depth[run.pixel] = depth;
        seen = of_sample;
    });
}

}  // namespace raylex::display
