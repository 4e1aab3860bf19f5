// Sums that channels have in common: a block of samples is added up once for each set of channels that took its light.
#include "display/buffer/frame_buffer_storage.h"

namespace raylex::display {
namespace {

/// All three or, where one would not fit, none and false.
bool add_all(Int128* to, const SetSums::Sum& terms) {
    SetSums::Sum result;
    bool fits = true;
    for (std::size_t c = 0; c < 3; ++c) {
        result[c] = to[c];
        fits = add_fixed(result[c], terms[c]) && fits;
    }
    if (fits) std::copy_n(result.begin(), 3, to);
    return fits;
}

}  // namespace

std::vector<std::uint8_t> FrameBuffer::sums_only() const {
    const Storage& storage = *storage_;
    const std::span<const ChannelDefinition> channels = storage.definitions;
    std::vector<std::uint8_t> result(channels.size(), 0);
    if (storage.kernel || storage.raster_kernel) return result;
    for (std::size_t i = 0; i < channels.size(); ++i) {
        const ChannelDefinition& channel = channels[i];
        const KeptStatistics kept = kept_statistics(channels, i);
        result[i] = channel.style == ChannelStyle::expression && channel.type == ChannelType::rgb && takes_samples(channel) &&
                    keeps_pixels(channel) && channel.rule == FilterRule::filter && !kept.moments && !kept.halves;
    }
    for (const ChannelDefinition& channel : channels)  // further outputs look at samples by rules of their own
        if (!takes_samples(channel)) result[static_cast<std::size_t>(channel.source)] = 0;
    return result;
}

void FrameBuffer::expect(const SplatSets& sets) {
    Storage& storage = *storage_;
    const auto own = [&](const Storage::Taker& taker) { return sets.shared()[taker.from] == 0; };
    const auto end = std::stable_partition(storage.takers.begin(), storage.takers.end(), own);
    storage.own_takers = static_cast<std::size_t>(end - storage.takers.begin());
}

void FrameBuffer::Storage::add_sets(const SampleTable& table, const Run& run, std::uint64_t stripes) {
    const SplatSets& sets = *table.sets();
    SetSums& of_run = *run.set_sums;
    const auto first = static_cast<std::size_t>(table.channel_count()), begin = static_cast<std::size_t>(run.begin),
               count = static_cast<std::size_t>(run.end) - begin;
    const std::span<const std::uint32_t> in_use = table.sets_in_use();
    const std::span<const std::uint64_t> touched = table.touched_stripes().subspan(first);
    if (of_run.sums.size() < channels.size()) {
        of_run.sums.resize(channels.size());
        of_run.taken.resize(channels.size());
    }
    for (std::size_t column = 0; column < in_use.size(); ++column) {
        if ((touched[column] & stripes) == 0) continue;
        const double* const values = table.values(static_cast<ChannelId>(first + column));
        std::array<double, 3> sum = weighted_sum<3>(values + 3 * begin, run.sum_weights(), count);
        if (run.extra != nullptr)  // a camera ray has the light of all its rows
            for (std::size_t i = 0; i < count; ++i)
                for (const int row : run.extra->of(run.begin + static_cast<int>(i)))
                    for (std::size_t c = 0; c < 3; ++c)
                        sum[c] += run.weights[i] * values[3 * static_cast<std::size_t>(row) + c];
        if (is_zero(sum)) continue;
        SetSums::Sum fixed{};
        bool fits = true;
        for (std::size_t c = 0; c < 3; ++c) fits = fits && to_fixed(sum[c], layout.quantum_exponent, fixed[c]);
        for (const ChannelId id : sets.channels_of(in_use[column])) {
            const auto channel = static_cast<std::uint32_t>(id);
            if (!fits) {
                reject(channel);
                continue;
            }
            if (of_run.taken[channel] == 0) {
                of_run.taken[channel] = 1;
                of_run.channels.push_back(channel);
                const Int128* const pixel = sum_of[channel] + 3 * run.pixel;
                __builtin_prefetch(pixel, 1);
                __builtin_prefetch(pixel + 2, 1);
            }
            if (!add_all(of_run.sums[channel].data(), fixed)) reject(channel);
        }
    }
    add_waiting(of_run);
    of_run.waiting_pixel = run.pixel;
    for (const std::uint32_t channel : of_run.channels) {
        of_run.waiting.push_back({channel, of_run.sums[channel]});
        of_run.sums[channel] = {};
        of_run.taken[channel] = 0;
    }
    of_run.channels.clear();
}

void FrameBuffer::Storage::add_waiting(SetSums& sums) {
    for (const SetSums::Addend& each : sums.waiting) {
        Int128* const pixel = sum_of[each.channel] + 3 * sums.waiting_pixel;
        if (!add_all(pixel, each.sum)) reject(each.channel);
    }
    sums.waiting.clear();
}

}  // namespace raylex::display
