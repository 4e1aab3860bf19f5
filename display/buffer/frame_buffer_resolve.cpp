// From the record to pixels, and from two records to one.
#include "display/buffer/frame_buffer_storage.h"

#include "display/services/parameters.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace raylex::display {
namespace {

/// The nearest long double to `fixed`, at a third of the time that the compiler's own conversion takes: both halves and
/// the scaling are exact, so only the addition rounds.
long double as_long_double(Int128 fixed) {
    const auto high = static_cast<std::int64_t>(fixed >> 64);
    const auto low = static_cast<std::uint64_t>(fixed);
    return static_cast<long double>(high) * 0x1p64L + static_cast<long double>(low);
}

/// What sums of one pixel are divided by, all in quanta. A pixel whose weights cancel is divided by its sample count:
/// weights have mean 1. The reciprocal costs at most 1.5 units in the last of 64 bits before rounding to 53, so a mean
/// of equal values is that value.
struct Divisor {
    long double reciprocal = 0;
    std::uint64_t samples = 0;
    int exponent = 0;

    Divisor(Int128 weight_sum, std::uint64_t sample_count, int quantum_exponent)
        : reciprocal(weight_sum != 0 ? 1.0L / as_long_double(weight_sum) : 0.0L),
          samples(sample_count),
          exponent(quantum_exponent) {}
    [[nodiscard]] double mean_of(Int128 sum) const {
        if (sum == 0) return 0;
        if (reciprocal != 0) return static_cast<double>(as_long_double(sum) * reciprocal);
        if (samples == 0) return 0;
        return static_cast<double>(to_long_double(sum, exponent) / static_cast<long double>(samples));
    }
};

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

std::size_t pixel_count(const PixelRegion& region) {
    return static_cast<std::size_t>(region.width()) * static_cast<std::size_t>(region.height());
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
    return resolve(id, {0, 0, storage_->layout.width, storage_->layout.height});
}

std::vector<double> FrameBuffer::resolve(ChannelId id, const PixelRegion& region) const {
    const Storage& storage = *storage_;
    const Channel& channel = storage.channels[static_cast<std::size_t>(id)];
    const auto components = static_cast<std::size_t>(channel.components);
    const int exponent = storage.layout.quantum_exponent;
    const FilterRule rule = channel.definition.rule;
    const double miss =
        channel.definition.style == ChannelStyle::name ? static_cast<double>(channel.definition.miss_value) : 0;
    std::vector<double> result(pixel_count(region) * components);
    for_each_pixel(region, storage.layout.width, [&](std::size_t at, std::size_t pixel) {
        double* out = &result[at * components];
        const std::size_t in = pixel * components;
        if (rule == FilterRule::filter) {
            const Divisor divisor(storage.weight[pixel], storage.samples[pixel], exponent);
            for (std::size_t c = 0; c < components; ++c) out[c] = divisor.mean_of(channel.sum[in + c]);
        } else if (channel.seen[pixel] == 0) {
            std::fill_n(out, components, miss);
        } else if (is_z_rule(rule) || is_extremum(rule)) {
            std::copy_n(&channel.picked[in], components, out);
        } else {
            const Divisor divisor(0, rule == FilterRule::sum ? 1 : channel.seen[pixel], exponent);
            for (std::size_t c = 0; c < components; ++c) out[c] = divisor.mean_of(channel.sum[in + c]);
        }
    });
    return result;
}

std::vector<double> FrameBuffer::resolve_alpha() const {
    return resolve_alpha({0, 0, storage_->layout.width, storage_->layout.height});
}

std::vector<double> FrameBuffer::resolve_alpha(const PixelRegion& region) const {
    const Storage& storage = *storage_;
    std::vector<double> result(pixel_count(region));
    for_each_pixel(region, storage.layout.width, [&](std::size_t at, std::size_t pixel) {
        result[at] =
            Divisor(storage.weight[pixel], storage.samples[pixel], storage.layout.quantum_exponent)
                .mean_of(storage.alpha[pixel]);
    });
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
