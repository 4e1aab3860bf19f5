// Sums that channels have in common: a block of samples is added up once for each set of channels that took its light.
#include "display/buffer/frame_buffer_storage.h"

namespace raylex::display {

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

void SetSums::begin(const SampleTable& table, std::size_t channel_count) {
    if (sums.size() < channel_count) {
        sums.resize(channel_count);
        taken.resize(channel_count);
    }
    order.clear();
    for (const std::uint32_t set : table.sets_in_use()) order.emplace_back(set, static_cast<std::uint32_t>(order.size()));
    std::sort(order.begin(), order.end());
}

void FrameBuffer::Storage::add_sets(const SampleTable& table, const Run& run, std::uint64_t stripes) {
    const SplatSets& sets = *table.sets();
    SetSums& of_run = *run.set_sums;
    const auto first = static_cast<std::size_t>(table.channel_count()), begin = static_cast<std::size_t>(run.begin),
               count = static_cast<std::size_t>(run.end) - begin;
    const std::span<const std::uint64_t> touched = table.touched_stripes().subspan(first);
    of_run.weights.resize(count);
    for (std::size_t i = 0; i < count; ++i)
        of_run.weights[i] = static_cast<double>(table.camera_row(run.begin + static_cast<int>(i)).filter_weight);
    for (const auto& [set, column] : of_run.order) {
        if ((touched[column] & stripes) == 0) continue;
        const double* v = table.values(static_cast<ChannelId>(first + column)) + 3 * begin;
        std::array<double, 3> sum{};
        for (std::size_t i = 0; i < count; ++i, v += 3)
            for (std::size_t c = 0; c < 3; ++c) sum[c] += of_run.weights[i] * v[c];
        if (sum == std::array<double, 3>{}) continue;
        for (const ChannelId id : sets.channels_of(set)) {
            const auto channel = static_cast<std::uint32_t>(id);
            if (of_run.taken[channel] == 0) {
                of_run.taken[channel] = 1;
                of_run.channels.push_back(channel);
                const Int128* const pixel = sum_of[channel] + 3 * run.pixel;
                __builtin_prefetch(pixel, 1);
                __builtin_prefetch(pixel + 2, 1);
            }
            for (std::size_t c = 0; c < 3; ++c) of_run.sums[channel][c] += sum[c];
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
    for (const SetSums::Addend& each : sums.waiting)
        add(channels[each.channel].sum, 3 * sums.waiting_pixel, each.sum.data(), 3, layout.quantum_exponent, each.channel);
    sums.waiting.clear();
}

}  // namespace raylex::display
