// Sums shared by channels: each block of samples is summed once per set of channels that took its light.
#include "display/buffer/frame_buffer/frame_buffer_storage.h"

#include <bit>

namespace raylex::display {
std::vector<std::uint8_t> FrameBuffer::sums_only() const {
    const Storage& storage = *storage_;
    const std::span<const ChannelDefinition> channels = storage.definitions;
    std::vector<std::uint8_t> result(channels.size(), 0);
    if (storage.kernel || storage.raster_kernel) return result;
    for (std::size_t i = 0; i < channels.size(); ++i) {
        const ChannelDefinition& channel = channels[i];
        const KeptStatistics kept = kept_statistics(channels, i);
        result[i] = channel.style == ChannelStyle::expression && channel.type == ChannelType::rgb &&
                    takes_samples(channel) && keeps_pixels(channel) && channel.rule == FilterRule::filter &&
                    !kept.moments && !kept.halves;
    }
    for (const ChannelDefinition& channel : channels)  // further outputs use samples by rules of their own
        if (!takes_samples(channel)) result[static_cast<std::size_t>(channel.source)] = 0;
    return result;
}

void FrameBuffer::expect(const SplatSets& sets) {
    Storage& storage = *storage_;
    const auto own = [&](const Storage::Accumulator& accumulator) { return sets.shared()[accumulator.from] == 0; };
    const auto end = std::stable_partition(storage.accumulators.begin(), storage.accumulators.end(), own);
    storage.own_accumulators = static_cast<std::size_t>(end - storage.accumulators.begin());
}

void FrameBuffer::Storage::add_sets(const SampleTable& table, const Run& run) {
    const SplatSets& sets = *table.sets();
    SetSums& of_run = *run.set_sums;
    if (of_run.sums.size() < channels.size()) {
        of_run.sums.resize(channels.size());
        of_run.taken.resize(channels.size());
    }
    const std::span<const std::uint32_t> in_use = table.sets_in_use();
    for (std::size_t chunk = 0; chunk * SampleTable::set_chunk < in_use.size(); ++chunk) {
        SampleTable::SetMask any{};
        run.for_each_block([&](int first, int, std::size_t) {
            const SampleTable::SetMask& mask = table.set_mask(first, chunk);
            for (std::size_t word = 0; word < any.size(); ++word) any[word] |= mask[word];
        });
        for (std::size_t word = 0; word < any.size(); ++word)
            for (std::uint64_t places = any[word]; places != 0; places &= places - 1) {
                const std::size_t place =
                    SampleTable::set_chunk * chunk + 64 * word + static_cast<std::size_t>(std::countr_zero(places));
                add_set(table, run, place, sets.channels_of(in_use[place]));
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

/// Adds the block sums of one set to the run's sum of each of its channels.
inline void FrameBuffer::Storage::add_set(const SampleTable& table, const Run& run, std::size_t place,
                                          std::span<const ChannelId> set) {
    SetSums& of_run = *run.set_sums;
    const int exponent = exponents[static_cast<std::size_t>(set.front())];  // equal for all channels of light
    FixedSum<3> of_set(exponent);
    run.for_each_block([&](int first, int, std::size_t) {
        const std::array<double, 3> sum = table.set_sum(first, place);
        if (of_set.add(sum)) [[likely]]
            return;
        for (const ChannelId id : set)
            add_block(sum_of[static_cast<std::size_t>(id)] + 3 * run.pixel, sum, exponent,
                      static_cast<std::size_t>(id));
    });
    const SetSums::Sum total = of_set.total();
    if ((total[0] | total[1] | total[2]) == 0) return;
    for (const ChannelId id : set) {
        const auto channel = static_cast<std::uint32_t>(id);
        if (of_run.taken[channel] == 0) {
            of_run.taken[channel] = 1;
            of_run.channels.push_back(channel);
            const Int128* const pixel = sum_of[channel] + 3 * run.pixel;
            __builtin_prefetch(pixel, 1);
            __builtin_prefetch(pixel + 2, 1);
        }
        for (std::size_t c = 0; c < 3; ++c) of_run.sums[channel][c] += total[c];
    }
}

void FrameBuffer::Storage::add_waiting(SetSums& sums) {
    for (const SetSums::Addend& each : sums.waiting)
        if (!add_total<3>(sum_of[each.channel] + 3 * sums.waiting_pixel, each.sum)) reject(each.channel);
    sums.waiting.clear();
}

}  // namespace raylex::display
