#include "display/buffer/frame_buffer/frame_buffer.h"

#include "display/buffer/frame_buffer/frame_buffer_storage.h"
#include "display/services/parameters.h"

#include <bit>
#include <cmath>
#include <optional>
#include <string>

namespace raylex::display {
namespace {

Status check_layout(const FrameBufferLayout& layout) {
    if (layout.width <= 0 || layout.height <= 0)
        return error_at({}, "frame buffer of " + std::to_string(layout.width) + " x " + std::to_string(layout.height) +
                                " pixels; expected positive width and height");
    if (layout.block_size <= 0 || !std::has_single_bit(static_cast<unsigned>(layout.block_size)))
        return error_at({},
                        "frame buffer block size " + std::to_string(layout.block_size) + "; expected a power of two");
    // The limit keeps sums that include the channels' scales within range: records from outside can contain any value.
    constexpr int largest_exponent = 512;
    if (layout.quantum_exponent < -largest_exponent || layout.quantum_exponent > largest_exponent)
        return error_at(
            {}, "frame buffer of quanta of 2^" + std::to_string(layout.quantum_exponent) + "; expected -512 to 512");
    return success();
}

Status check_scales(std::span<const ChannelDefinition> channels) {
    const ChannelDefinition* light = nullptr;
    for (const ChannelDefinition& channel : channels) {
        const int scale = channel.scale_exponent;
        if (scale < -largest_scale_exponent || scale > largest_scale_exponent)  // abs(INT_MIN) is negative
            return error_at({}, "channel '" + channel.name + "' has values of the order of 2^" + std::to_string(scale) +
                                    "; expected -256 to 256");
        if (channel.source != invalid_channel && static_cast<std::size_t>(channel.source) < channels.size() &&
            channels[static_cast<std::size_t>(channel.source)].scale_exponent != scale)
            return error_at({},
                            "layer '" + channel.name + "' and its source have different scales; expected equal ones");
        if (channel.style != ChannelStyle::expression) continue;
        if (light == nullptr) light = &channel;
        if (light->scale_exponent != scale)
            return error_at({}, "channels '" + light->name + "' and '" + channel.name +
                                    "' of light have different scales; expected equal ones");
    }
    return success();
}

Status check_outputs(std::span<const ChannelDefinition> channels) {
    for (const ChannelDefinition& layer : channels) {
        if (takes_samples(layer) && keeps_pixels(layer)) continue;
        const bool output = keeps_pixels(layer);
        const std::string who =
            "channel '" + layer.name + "' is " + (output ? "a further output" : "a layer of statistics");
        if (layer.source < 0 || static_cast<std::size_t>(layer.source) >= channels.size())
            return error_at({}, who + " of no channel; expected the id of one");
        const ChannelDefinition& source = channels[static_cast<std::size_t>(layer.source)];
        if (output && takes_samples(source) && source.type == layer.type) continue;
        if (output)
            return error_at({},
                            who + " of '" + source.name + "'; expected a channel of the same type that takes samples");
        if (!takes_samples(source) || source.rule != FilterRule::filter || source.type != layer.type)
            return error_at({}, who + " of '" + source.name +
                                    "'; expected a channel of the same type that the pixel filter is applied to");
    }
    return success();
}

Status check_splat(std::span<const ChannelDefinition> channels) {
    for (const ChannelDefinition& channel : channels)
        if (channel.statistics || !keeps_pixels(channel))
            return error_at(
                {},
                "channel '" + channel.name +
                    "' has statistics, but in splat mode "
                    "neighbouring pixels share samples, so their errors cannot be estimated; expected importance mode");
    return success();
}

Status check_raster(std::span<const ChannelDefinition> channels) {
    for (const ChannelDefinition& channel : channels) {
        if (channel.statistic == Statistic::even || channel.statistic == Statistic::odd)
            return error_at({}, "channel '" + channel.name +
                                    "' is one half of a pixel's samples, but raster splats "
                                    "belong to neither half; expected channels without halves");
        const ChannelDefinition& source =
            takes_samples(channel) ? channel : channels[static_cast<std::size_t>(channel.source)];
        if (source.style == ChannelStyle::expression && channel.rule != FilterRule::filter)
            return error_at({}, "channel '" + channel.name +
                                    "' takes raster splats, which have no rule but the "
                                    "pixel filter; expected the rule filter");
    }
    return success();
}

}  // namespace

int splat_reach(float radius) {
    return std::max(0, static_cast<int>(std::ceil(radius + 0.5f)) - 1);
}

void FrameBuffer::Storage::allocate_moments(Channel& channel, std::size_t values) {
    channel.plain_sum.allocate(values);
    channel.square_sum.allocate(values);
    if (weight_square.empty()) weight_square.allocate(pixel_count());
}

void FrameBuffer::Storage::allocate_halves(Channel& channel, std::size_t values) {
    channel.even_sum.allocate(values);
    channel.odd_sum.allocate(values);
    if (!even_weight.empty()) return;
    even_weight.allocate(pixel_count());
    odd_weight.allocate(pixel_count());
    even_samples.allocate(pixel_count());
    odd_samples.allocate(pixel_count());
}

FrameBuffer::FrameBuffer(const FrameBufferLayout& layout, std::span<const ChannelDefinition> channels,
                         const PixelFilter* splat, const PixelFilter* raster)
    : storage_(std::make_unique<Storage>()) {
    Storage& storage = *storage_;
    if (splat != nullptr) storage.set_kernel(*splat);
    if (raster != nullptr) storage.set_raster_kernel(*raster);
    storage.layout = layout;
    storage.definitions.assign(channels.begin(), channels.end());
    const std::size_t pixels = storage.pixel_count();
    storage.samples.allocate(pixels);
    storage.weight.allocate(pixels);
    storage.alpha.allocate(pixels);
    for (std::size_t index = 0; index < channels.size(); ++index) {
        const ChannelDefinition& definition = channels[index];
        const KeptStatistics kept = kept_statistics(channels, index);
        Channel& channel = storage.channels.emplace_back();
        channel.definition = definition;
        channel.components = component_count(definition.type);
        channel.samples_of = takes_samples(definition) ? static_cast<ChannelId>(index) : definition.source;
        if (!keeps_pixels(definition)) continue;
        const std::size_t values = pixels * static_cast<std::size_t>(channel.components);
        const FilterRule rule = definition.rule;
        const bool kernel = rule == FilterRule::filter,
                   expression =
                       channels[static_cast<std::size_t>(channel.samples_of)].style == ChannelStyle::expression;
        const float fill = expression ? 0.0f : definition.miss_value;
        if (is_z_rule(rule) || is_extremum(rule)) {
            channel.picked.allocate(values);
            if (is_z_rule(rule)) channel.depth.allocate(pixels);
        } else {
            channel.sum.allocate(values);
        }
        if (raster != nullptr && kernel && expression) {
            channel.raster_sum.allocate(values);
            storage.raster_channels.push_back(index);
        }
        if (!kernel) channel.seen.allocate(pixels);
        if (kept.moments) storage.allocate_moments(channel, values);
        if (kept.halves) storage.allocate_halves(channel, values);
        const auto place = [&](const auto& plane) {
            return plane.empty() ? Storage::Accumulator::Place{}
                                 : Storage::Accumulator::Place{
                                       plane.bytes().data(), static_cast<std::uint32_t>(plane.bytes().size() / pixels)};
        };
        using Places = std::array<Storage::Accumulator::Place, 3>;
        storage.accumulators.push_back(
            {static_cast<std::uint32_t>(index), static_cast<std::uint32_t>(channel.samples_of),
             kernel ? fill != 0 && std::isfinite(fill) : expression && rule != FilterRule::sum,
             kernel && std::isfinite(fill) && !kept.moments && !kept.halves && splat == nullptr, !expression,
             static_cast<std::uint32_t>(channel.components),
             channel.picked.empty() ? Places{place(channel.sum), place(channel.plain_sum), place(channel.square_sum)}
                                    : Places{place(channel.picked), place(channel.depth), place(channel.seen)}});
    }
    storage.own_accumulators = storage.accumulators.size();
    for (Channel& channel : storage.channels) {
        storage.sum_of.push_back(channel.sum.empty() ? nullptr : &channel.sum[0]);
        storage.exponents.push_back(layout.quantum_exponent + channel.definition.scale_exponent);
    }
    storage.exponents.push_back(layout.quantum_exponent);
    if (raster != nullptr) storage.light_paths.allocate(1);
    storage.rejected = std::make_unique<std::atomic<std::uint64_t>[]>(channels.size() + 1);
}

FrameBuffer::~FrameBuffer() = default;
FrameBuffer::FrameBuffer(FrameBuffer&&) noexcept = default;
FrameBuffer& FrameBuffer::operator=(FrameBuffer&&) noexcept = default;

Result<FrameBuffer> FrameBuffer::create(const FrameBufferLayout& layout, std::span<const ChannelDefinition> channels,
                                        const PixelFilter* splat, const PixelFilter* raster) {
    if (splat != nullptr)
        if (const Status status = check_splat(channels); !status) return status.error();
    if (const Status status = check_layout(layout); !status) return status.error();
    if (const Status status = check_scales(channels); !status) return status.error();
    if (const Status status = check_outputs(channels); !status) return status.error();
    if (raster != nullptr)
        if (const Status status = check_raster(channels); !status) return status.error();
    try {
        return FrameBuffer(layout, channels, splat, raster);
    } catch (const std::bad_alloc&) {
        return error_at({}, "not enough memory for a frame buffer of " + std::to_string(layout.width) + " x " +
                                std::to_string(layout.height) + " pixels and " + std::to_string(channels.size()) +
                                " channels; expected about 48 bytes per pixel and colour channel");
    }
}

namespace {

/// Returns the end of the run of camera rows from `begin` on: rows of one pixel and at most `most_blocks` blocks of
/// samples. `ends` gets the end of each of these blocks.
int end_of_run(const SampleTable& table, int begin, int block_bits, std::size_t most_blocks, std::vector<int>& ends) {
    const CameraRow& first = table.camera_row(begin);
    ends.clear();
    int end = begin + 1;
    for (; end < table.camera_row_count(); ++end) {
        const CameraRow& row = table.camera_row(end);
        if (row.pixel_x != first.pixel_x || row.pixel_y != first.pixel_y) break;
        if (row.sample >> block_bits == table.camera_row(end - 1).sample >> block_bits) continue;
        if (ends.size() + 1 == most_blocks) break;
        ends.push_back(end);
    }
    ends.push_back(end);
    return end;
}

/// The index of the row's pixel; none if it is outside the image or its band.
std::optional<std::size_t> pixel_of(const FrameBufferLayout& layout, const CameraRow& row) {
    const int y = row.pixel_y - layout.first_row;
    if (row.pixel_x < 0 || y < 0 || row.pixel_x >= layout.width || y >= layout.height) return {};
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(layout.width) + static_cast<std::size_t>(row.pixel_x);
}

}  // namespace

void FrameBuffer::accumulate(const SampleTable& table) {
    if (table.discarded()) return;
    if (table.sets() != nullptr &&
        table.sets()->block_bits() != std::countr_zero(static_cast<unsigned>(storage_->layout.block_size))) {
        storage_->reject(storage_->channels.size());  // their sums would be of other samples than the blocks here
        return;
    }
    thread_local BatchScratch scratch;
    thread_local SplatWeights splat;
    thread_local SetSums set_sums;
    const int cameras = table.camera_row_count();
    scratch.rays.gather(table);
    scratch.weights.resize(static_cast<std::size_t>(cameras));
    bool unit_weights = true;
    for (int row = 0; row < cameras; ++row) {
        const float weight = table.camera_row(row).filter_weight;
        scratch.weights[static_cast<std::size_t>(row)] = static_cast<double>(weight);
        unit_weights &= weight == 1.0f;
    }

    const FrameBufferLayout& layout = storage_->layout;
    const int block = std::countr_zero(static_cast<unsigned>(layout.block_size));  // block_size is a power of two: see
                                                                                   // check_layout()
    for (int begin = 0, end = 0; begin < cameras; begin = end) {
        const CameraRow& first = table.camera_row(begin);
        end = end_of_run(table, begin, block, storage_->kernel ? 1 : Run::most_blocks, scratch.block_ends);
        Run run;
        const std::optional<std::size_t> pixel = pixel_of(layout, first);
        if (!pixel && !storage_->kernel) {
            storage_->reject(storage_->channels.size());
            continue;
        }
        run.inside = pixel.has_value();
        if (pixel) run.pixel = *pixel;
        if (end < cameras) run.next_pixel = pixel_of(layout, table.camera_row(end)).value_or(Run::no_pixel);
        if (storage_->kernel) {
            splat.gather(table, *storage_->kernel, layout, begin, end);
            run.splat = &splat;
        }
        run.begin = begin;
        run.end = end;
        run.block_ends = scratch.block_ends;
        scratch.nearest.assign(scratch.block_ends.size(), -1);
        run.nearest = &scratch.nearest;
        run.rays = &scratch.rays;
        run.scratch = &scratch.folded;
        run.set_sums = &set_sums;
        run.alpha = scratch.rays.alpha();
        run.weights = scratch.weights.data() + begin;
        run.unit_weights = unit_weights;
        accumulate_run(table, run);
    }
    if (table.sets() != nullptr) storage_->add_waiting(set_sums);
    if (!unit_weights || storage_->kernel) storage_->note_lights(table, scratch.weights);
}

void FrameBuffer::accumulate_run(const SampleTable& table, const Run& run) {
    Storage& storage = *storage_;
    const int exponent = storage.layout.quantum_exponent;
    const std::size_t pixel = run.pixel, none = storage.channels.size();
    if (run.next_pixel != Run::no_pixel) storage.prefetch(run.next_pixel);
    if (run.inside) storage.samples[pixel] += static_cast<std::uint64_t>(run.end - run.begin);
    if (run.splat != nullptr) {
        storage.splat_weights(run);
        accumulate_channels(table, run);
        return;
    }
    using Sum = std::array<double, 1>;
    const auto add = [&](Plane<Int128>& to, auto term) {
        storage.add_blocks<1>(&to[pixel], run, exponent, none, [&](int first, int last) {
            double sum = 0;
            for (int row = first; row < last; ++row) sum += term(run.weights[row - run.begin], row);
            return Sum{sum};
        });
    };
    add(storage.weight, [](double w, int) { return w; });
    add(storage.alpha, [&](double w, int row) { return w * run.alpha[static_cast<std::size_t>(row)]; });
    if (!storage.weight_square.empty()) add(storage.weight_square, [](double w, int) { return w * w; });
    if (!storage.even_weight.empty()) storage.add_half_weights(table, run);

    accumulate_channels(table, run);
}

/// A special case of add_filtered(): only the weighted sum is kept, and no sample has extra rows.
template <std::size_t components>
inline void FrameBuffer::Storage::add_sum(const Accumulator& accumulator, const SampleTable& table, const Run& run) {
    const double* const values = table.values(static_cast<ChannelId>(accumulator.from));
    add_blocks<components>(sum_of[accumulator.channel] + run.pixel * components, run, exponents[accumulator.channel],
                           accumulator.channel, [&](int first, int last) {
                               return weighted_sum<components>(values + static_cast<std::size_t>(first) * components,
                                                               run.sum_weights(first),
                                                               static_cast<std::size_t>(last - first));
                           });
}

void FrameBuffer::accumulate_channels(const SampleTable& table, const Run& run) {
    Storage& storage = *storage_;
    std::uint64_t stripes = table.stripes_of(run.begin, run.end);
    const bool extra = run.rays->any_extra(), partial = run.rays->any_partial();
    if (extra)  // extra rows can be anywhere after the camera rows
        run.for_each_row([&](int row) { stripes |= table.stripes_of(row, row + 1); });
    const std::span<const std::uint64_t> touched = table.touched_stripes();
    const auto accumulates = [&](const Storage::Accumulator& accumulator) {
        return (touched[accumulator.from] & stripes) != 0 || accumulator.reads_untouched;
    };
    const bool by_sets = table.sets() != nullptr;
    if (by_sets) storage.add_sets(table, run);
    const std::span<const Storage::Accumulator> accumulators(
        storage.accumulators.data(),
        by_sets && !table.sent_separately() ? storage.own_accumulators : storage.accumulators.size());
    // A pixel of each channel is on a different memory page. Prefetching it one run ahead hides the latency; the next
    // run mostly uses the same channels.
    const auto prefetch = [&](const Storage::Accumulator& accumulator, std::size_t pixel) {
        for (const Storage::Accumulator::Place& place : accumulator.places) {
            if (place.first == nullptr) continue;
            const char* const first = place.first + pixel * place.pixel_bytes;
            __builtin_prefetch(first, 1);
            __builtin_prefetch(first + place.pixel_bytes - 1, 1);
        }
    };
    for (const Storage::Accumulator& accumulator : accumulators) {
        if (!accumulates(accumulator)) continue;
        if (run.begin == 0) prefetch(accumulator, run.pixel);
        if (run.next_pixel != Run::no_pixel) prefetch(accumulator, run.next_pixel);
    }
    for (const Storage::Accumulator& accumulator : accumulators) {
        if (!accumulates(accumulator)) continue;
        if (accumulator.sums_only && !extra && !(partial && accumulator.plain)) {
            if (accumulator.components == 3) storage.add_sum<3>(accumulator, table, run);
            else storage.add_sum<1>(accumulator, table, run);
            continue;
        }
        Channel& channel = storage.channels[accumulator.channel];
        const std::size_t from = accumulator.from;
        if (channel.definition.rule == FilterRule::filter) storage.add_filtered(channel, from, table, run);
        else if (!run.inside) continue;
        else if (channel.definition.rule == FilterRule::average || channel.definition.rule == FilterRule::sum)
            storage.add_plain(channel, from, table, run);
        else storage.add_picked(channel, from, table, run);
    }
}

}  // namespace raylex::display
