// From the record to pixels, and from two records to one.
#include "display/buffer/frame_buffer_storage.h"

#include "display/services/parameters.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace raylex::display {
namespace {

/// sum / weight, both in quanta. A pixel whose weights cancel is divided by its sample count: weights have mean 1.
double mean_of(Int128 sum, Int128 weight, std::uint64_t samples, int exponent) {
    if (weight != 0) return static_cast<double>(static_cast<long double>(sum) / static_cast<long double>(weight));
    if (samples == 0) return 0;
    return static_cast<double>(to_long_double(sum, exponent) / static_cast<long double>(samples));
}

/// Empty when the two channels have the same record, else what differs.
std::string difference(const ChannelDefinition& a, const ChannelDefinition& b) {
    if (a.name != b.name) return "'" + a.name + "' against '" + b.name + "'";
    const std::string channel = "channel '" + a.name + "' has another ";
    if (a.style != b.style || a.type != b.type) return channel + "style or type";
    if (a.expression != b.expression || a.dialect != b.dialect || a.rest_of != b.rest_of) return channel + "expression";
    if (a.rule != b.rule) return channel + "filter rule";
    if (a.space != b.space) return channel + "space";
    if (a.statistics != b.statistics) return channel + "statistics setting";
    if (a.miss_value != b.miss_value) return channel + "miss value";
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

std::vector<double> FrameBuffer::resolve(ChannelId id) const {
    const Storage& storage = *storage_;
    const Channel& channel = storage.channels[static_cast<std::size_t>(id)];
    const auto components = static_cast<std::size_t>(channel.components);
    const int exponent = storage.layout.quantum_exponent;
    const FilterRule rule = channel.definition.rule;
    const double miss =
        channel.definition.style == ChannelStyle::name ? static_cast<double>(channel.definition.miss_value) : 0;
    std::vector<double> result(storage.pixel_count() * components);
    for (std::size_t i = 0; i < result.size(); ++i) {
        const std::size_t pixel = i / components;
        if (rule == FilterRule::filter)
            result[i] = mean_of(channel.sum[i], storage.weight[pixel], storage.samples[pixel], exponent);
        else if (channel.seen[pixel] == 0) result[i] = miss;
        else if (is_z_rule(rule) || is_extremum(rule)) result[i] = channel.picked[i];
        else result[i] = mean_of(channel.sum[i], 0, rule == FilterRule::sum ? 1 : channel.seen[pixel], exponent);
    }
    return result;
}

std::vector<double> FrameBuffer::resolve_alpha() const {
    const Storage& storage = *storage_;
    std::vector<double> result(storage.pixel_count());
    for (std::size_t i = 0; i < result.size(); ++i)
        result[i] = mean_of(storage.alpha[i], storage.weight[i], storage.samples[i], storage.layout.quantum_exponent);
    return result;
}

std::vector<double> FrameBuffer::resolve_variance_of_mean(ChannelId id) const {
    const Storage& storage = *storage_;
    const Channel& channel = storage.channels[static_cast<std::size_t>(id)];
    if (channel.square_sum.empty()) return {};
    const auto components = static_cast<std::size_t>(channel.components);
    const int exponent = storage.layout.quantum_exponent;
    std::vector<double> result(storage.pixel_count() * components);
    for (std::size_t i = 0; i < result.size(); ++i) {
        const std::size_t pixel = i / components;
        const std::uint64_t samples = storage.samples[pixel];
        if (samples < 2 || storage.weight[pixel] == 0) continue;
        const auto n = static_cast<long double>(samples);
        const long double weight = to_long_double(storage.weight[pixel], exponent);
        const long double mean = to_long_double(channel.sum[i], exponent) / weight;
        // sum(v^2) is exact to 2^-56, so nothing is lost but what these 64-bit mantissas round off: 2^-63 sum(v^2).
        const long double about_mean = to_long_double(channel.square_sum[i], Storage::square_exponent) -
                                       mean * (2 * to_long_double(channel.plain_sum[i], exponent) - n * mean);
        const long double weight_square = to_long_double(storage.weight_square[pixel], exponent);
        result[i] = static_cast<double>(std::max(0.0L, about_mean) * weight_square / ((n - 1) * weight * weight));
    }
    return result;
}

Status FrameBuffer::merge(const FrameBuffer& other) {
    Storage& mine = *storage_;
    const Storage& theirs = *other.storage_;
    if (!(mine.layout == theirs.layout))
        return error_at({}, "frame buffers of different size, block size or quantum cannot be merged");
    if (mine.channels.size() != theirs.channels.size())
        return error_at({}, "frame buffers with " + std::to_string(mine.channels.size()) + " and " +
                                std::to_string(theirs.channels.size()) + " channels cannot be merged");
    for (std::size_t i = 0; i < mine.channels.size(); ++i)
        if (const std::string text = difference(mine.definitions[i], theirs.definitions[i]); !text.empty())
            return error_at({}, "frame buffers with different channels cannot be merged: " + text);

    const auto add_plane = [&](Plane<Int128>& to, const Plane<Int128>& from, std::size_t channel) {
        for (std::size_t i = 0; i < to.size(); ++i)
            if (from[i] != 0 && !add_fixed(to[i], from[i])) mine.reject(channel);
    };
    for (std::size_t i = 0; i < mine.samples.size(); ++i) mine.samples[i] += theirs.samples[i];
    add_plane(mine.weight, theirs.weight, mine.channels.size());
    add_plane(mine.alpha, theirs.alpha, mine.channels.size());
    add_plane(mine.weight_square, theirs.weight_square, mine.channels.size());
    for (std::size_t i = 0; i < mine.channels.size(); ++i) {
        Channel& to = mine.channels[i];
        const Channel& from = theirs.channels[i];
        add_plane(to.sum, from.sum, i);
        add_plane(to.plain_sum, from.plain_sum, i);
        add_plane(to.square_sum, from.square_sum, i);
        if (to.picked.empty()) {
            for (std::size_t p = 0; p < to.seen.size(); ++p) to.seen[p] += from.seen[p];
        } else {
            mine.merge_picked(to, from);
        }
    }
    for (std::size_t i = 0; i <= mine.channels.size(); ++i) mine.rejected[i].fetch_add(theirs.rejected[i].load());
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
