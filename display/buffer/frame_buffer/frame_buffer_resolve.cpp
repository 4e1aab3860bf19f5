// Computes pixels from the record, and merges records.
#include "display/buffer/frame_buffer/frame_buffer_storage.h"

#include "display/services/parameters.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <type_traits>

namespace raylex::display {
namespace {

/// Describes the difference between the records of two channels; empty when they are equal.
std::string difference(const ChannelDefinition& a, const ChannelDefinition& b) {
    if (a.name != b.name) return "'" + a.name + "' against '" + b.name + "'";
    const std::string channel = "channel '" + a.name + "' has a different ";
    if (a.style != b.style || a.type != b.type) return channel + "style or type";
    if (a.expression != b.expression || a.dialect != b.dialect || a.rest_of != b.rest_of) return channel + "expression";
    if (a.rule != b.rule) return channel + "filter rule";
    if (a.space != b.space) return channel + "space";
    if (a.statistics != b.statistics || a.statistic != b.statistic || a.source != b.source)
        return channel + "statistics setting";
    if (a.miss_value != b.miss_value) return channel + "miss value";
    if (a.scale_exponent != b.scale_exponent) return channel + "scale";
    return {};
}

}  // namespace

const FrameBufferLayout& FrameBuffer::layout() const {
    return storage_->layout;
}

std::span<const ChannelDefinition> FrameBuffer::channels() const {
    return storage_->definitions;
}

std::uint64_t FrameBuffer::sample_count(int x, int y) const {
    return storage_->samples[static_cast<std::size_t>(y) * static_cast<std::size_t>(storage_->layout.width) +
                             static_cast<std::size_t>(x)];
}

std::uint64_t FrameBuffer::rejected_count() const {
    std::uint64_t count = 0;
    for (std::size_t i = 0; i <= storage_->channels.size(); ++i) count += storage_->rejected[i].load();
    return count;
}

std::uint64_t FrameBuffer::rejected_count(ChannelId id) const {
    return storage_->rejected[static_cast<std::size_t>(id)].load();
}

/// Channels that sets represent have the same sums as channels without sets, up to rounding.
void FrameBuffer::Storage::note_lights(const SampleTable& table, std::span<const double> weights) {
    double heaviest = 0;
    bool negative = kernel && kernel->has_negative_lobes();
    for (const double each : weights) {
        heaviest = std::max(heaviest, std::abs(each));
        negative = negative || each < 0;
    }
    if (!negative) return;
    if (kernel) heaviest *= std::abs(static_cast<double>(kernel->evaluate(0, 0)));
    for (const Accumulator& each : std::span(accumulators).first(own_accumulators)) {
        if (definitions[each.channel].style != ChannelStyle::expression || !table.touched(ChannelId(each.from)))
            continue;
        const std::span values(table.values(ChannelId(each.from)),
                               static_cast<std::size_t>(table.row_count()) * each.components);
        double largest = 0;
        for (const double value : values) largest = std::max(largest, std::abs(value));
        note_light(heaviest * largest);
    }
}

double FrameBuffer::light_magnitude() const {
    const Storage& storage = *storage_;
    const double largest = storage.largest_light.load();
    if (largest == 0) return 0;
    // If weights cancel, the divisor of a mean is smaller than the number of its samples.
    double most = 1;
    for (std::size_t pixel = 0; pixel < storage.samples.size(); ++pixel)
        if (storage.weight[pixel] != 0)
            most = std::max(most, static_cast<double>(storage.samples[pixel]) /
                                      std::abs(static_cast<double>(
                                          to_long_double(storage.weight[pixel], storage.layout.quantum_exponent))));
    return largest * most;
}

std::vector<double> FrameBuffer::resolve(ChannelId id, const PixelRegion& region) const {
    const Storage& storage = *storage_;
    const Channel& channel = storage.channels[static_cast<std::size_t>(id)];
    if (!keeps_pixels(channel.definition))
        return storage.statistic(storage.channels[static_cast<std::size_t>(channel.definition.source)],
                                 channel.definition.statistic, region);
    const auto components = static_cast<std::size_t>(channel.components);
    const int exponent = storage.layout.quantum_exponent;
    const int scale = channel.definition.scale_exponent;
    const FilterRule rule = channel.definition.rule;
    const double miss =
        channel.definition.style == ChannelStyle::name ? static_cast<double>(channel.definition.miss_value) : 0;
    std::vector<double> result(pixel_count(region) * components);
    const long double raster_scale = channel.raster_sum.empty() ? 0 : storage.raster_scale() * power_of_two(scale);
    for_each_pixel(region, storage.layout.width, [&](std::size_t at, std::size_t pixel) {
        double* out = &result[at * components];
        const std::size_t in = pixel * components;
        if (rule == FilterRule::filter) {
            Int128 any = 0;
            for (std::size_t c = 0; c < components; ++c) any |= channel.sum[in + c];
            if (any != 0) {  // skips the division: most layers are black in most pixels
                const Divisor divisor(storage.weight[pixel], storage.samples[pixel], exponent, scale);
                for (std::size_t c = 0; c < components; ++c) out[c] = divisor.mean_of(channel.sum[in + c]);
            }
            if (raster_scale == 0) return;
            for (std::size_t c = 0; c < components; ++c)
                out[c] += static_cast<double>(as_long_double(channel.raster_sum[in + c]) * raster_scale);
        } else if (channel.seen[pixel] == 0) {
            std::fill_n(out, components, miss);
        } else if (is_z_rule(rule) || is_extremum(rule)) {
            std::copy_n(&channel.picked[in], components, out);
        } else {
            const Divisor divisor(0, rule == FilterRule::sum ? 1 : channel.seen[pixel], exponent, scale);
            for (std::size_t c = 0; c < components; ++c) out[c] = divisor.mean_of(channel.sum[in + c]);
        }
    });
    return result;
}

std::vector<double> FrameBuffer::resolve_alpha(const PixelRegion& region) const {
    const Storage& storage = *storage_;
    std::vector<double> result(pixel_count(region));
    for_each_pixel(region, storage.layout.width, [&](std::size_t at, std::size_t pixel) {
        result[at] = Divisor(storage.weight[pixel], storage.samples[pixel], storage.layout.quantum_exponent)
                         .mean_of(storage.alpha[pixel]);
    });
    return result;
}

std::string FrameBuffer::difference_from(const FrameBuffer& other) const {
    const Storage& mine = *storage_;
    const Storage& theirs = *other.storage_;
    if (!(mine.layout == theirs.layout)) return "different size, block size or quantum";
    if (mine.kernel_name != theirs.kernel_name || mine.raster_kernel_name != theirs.raster_kernel_name)
        return "different pixel filters, filter modes or ways of splatting";
    if (mine.channels.size() != theirs.channels.size())
        return std::to_string(mine.channels.size()) + " and " + std::to_string(theirs.channels.size()) + " channels";
    for (std::size_t i = 0; i < mine.channels.size(); ++i)
        if (const std::string text = difference(mine.definitions[i], theirs.definitions[i]); !text.empty())
            return "different channels: " + text;
    return {};
}

Status FrameBuffer::merge(const FrameBuffer& other) {
    if (const std::string text = difference_from(other); !text.empty())
        return error_at({}, "frame buffers that do not match cannot be merged: " + text);
    Storage& mine = *storage_;
    const Storage& theirs = *other.storage_;

    // Sums are added exactly; picked values are merged by the rule of the channel.
    const auto add_plane = [&]<class T>(Plane<T>& to, const Plane<T>& from, std::size_t channel) {
        for (std::size_t i = 0; i < to.size(); ++i) {
            if constexpr (std::is_same_v<T, Int128>) {
                if (from[i] != 0 && !add_fixed(to[i], from[i])) mine.reject(channel);
            } else if constexpr (std::is_same_v<T, std::uint64_t>) {
                to[i] += from[i];
            }
        }
    };
    Storage::for_each_plane(
        [&](const char*, auto plane) { add_plane(mine.*plane, theirs.*plane, mine.channels.size()); });
    for (std::size_t i = 0; i < mine.channels.size(); ++i) {
        Channel& to = mine.channels[i];
        const Channel& from = theirs.channels[i];
        if (!to.picked.empty()) mine.merge_picked(to, from);
        else Channel::for_each_plane([&](const char*, auto plane) { add_plane(to.*plane, from.*plane, i); });
    }
    for (std::size_t i = 0; i <= mine.channels.size(); ++i) mine.rejected[i].fetch_add(theirs.rejected[i].load());
    mine.note_light(theirs.largest_light.load());
    return success();
}

void FrameBuffer::Storage::merge_picked(Channel& to, const Channel& from) const {
    const auto components = static_cast<std::size_t>(to.components);
    const FilterRule rule = to.definition.rule;
    for (std::size_t pixel = 0; pixel < to.seen.size(); ++pixel) {
        const std::uint64_t seen = from.seen[pixel];
        if (seen == 0) continue;
        double* best = &to.picked[pixel * components];
        const double* value = &from.picked[pixel * components];
        if (is_extremum(rule)) {
            for (std::size_t c = 0; c < components; ++c)
                best[c] = pick_extremum(rule, to.seen[pixel] == 0, best[c], value[c]);
            to.seen[pixel] += seen;
        } else if (z_rule_prefers(rule, from.depth[pixel], seen - 1, to.depth[pixel], to.seen[pixel])) {
            std::copy_n(value, components, best);
            to.depth[pixel] = from.depth[pixel];
            to.seen[pixel] = seen;
        }
    }
}

}  // namespace raylex::display
