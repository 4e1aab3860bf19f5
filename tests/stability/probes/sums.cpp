// Sums of very many samples in the frame buffer: means, variances, merged parts, filter weights, sizes.
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "display/buffer/frame_buffer/frame_buffer.h"
#include "display/buffer/frame_buffer/memory_estimate.h"
#include "display/buffer/pixel_filter.h"
#include "tests/stability/probes/counted_numbers.h"
#include "tests/stability/probes/probes.h"

namespace raylex::experiments {
namespace {

using display::ChannelDefinition;
using display::FrameBuffer;

constexpr int batch = 256;

std::vector<ChannelDefinition> one_channel(bool statistics) {
    ChannelDefinition channel;
    channel.name = "v";
    channel.type = display::ChannelType::real;
    channel.statistics = statistics;
    return {channel};
}

/// Fills samples [first, last) of the only pixel of `buffer`; `fill` sets a sample's value and the rest of its row.
template <class Fill>
void feed(FrameBuffer& buffer, std::uint64_t first, std::uint64_t last, Fill&& fill) {
    display::SampleTable table(buffer.channels(), batch);
    std::vector<display::CameraRow> rows;
    std::vector<double> values;
    for (std::uint64_t sample = first; sample < last;) {
        rows.clear();
        values.clear();
        for (; sample < last && rows.size() < batch; ++sample) {
            display::CameraRow row;
            row.sample = sample;
            values.push_back(fill(sample, row));
            rows.push_back(row);
        }
        table.begin(rows);
        std::copy(values.begin(), values.end(), table.raw_values(0));
        table.touch(0);
        buffer.accumulate(table);
    }
}

/// Returns the mean of two alternating values.
Result<ProbeResult> alternating_mean(const ProbeInput& input) {
    const double a = input.number("a"), b = input.number("b");
    const auto samples = static_cast<std::uint64_t>(input.number("samples"));
    if (Status given = input.status(); !given) return given.error();
    const std::vector<ChannelDefinition> channels = one_channel(false);
    FrameBuffer buffer({1, 1}, channels);
    feed(buffer, 0, samples, [&](std::uint64_t sample, display::CameraRow&) { return sample % 2 == 0 ? a : b; });
    ProbeResult result;
    result.measured = buffer.resolve(0)[0];
    const auto even = static_cast<double>((samples + 1) / 2), odd = static_cast<double>(samples / 2);
    result.expected = (a * even + b * odd) / (even + odd);
    return result;
}

/// Returns the variance of samples `offset` + N(0, deviation), from the frame buffer's variance of the mean.
Result<ProbeResult> sample_variance(const ProbeInput& input) {
    const double offset = input.number("offset"), deviation = input.number("deviation", 1);
    const auto samples = static_cast<std::uint64_t>(input.number("samples", 65536));
    const auto parts = static_cast<std::uint64_t>(input.number("parts", 1));
    CountedNumbers numbers(static_cast<std::uint64_t>(input.number("seed", 5)));
    if (Status given = input.status(); !given) return given.error();
    const std::vector<ChannelDefinition> channels = one_channel(true);
    // Parts are shards of samples, merged as by `raylex merge`.
    std::vector<FrameBuffer> buffers;
    long double sum = 0, squares = 0;
    const auto blocks = std::max<std::uint64_t>(1, samples / 16);
    for (std::uint64_t part = 0; part < parts; ++part) {
        buffers.emplace_back(display::FrameBufferLayout{1, 1}, channels);
        const std::uint64_t first = blocks * part / parts * 16, last = blocks * (part + 1) / parts * 16;
        feed(buffers.back(), first, last, [&](std::uint64_t, display::CameraRow&) {
            const double deviate = deviation * numbers.normal(), value = offset + deviate;
            // Relative to the offset, so that the reference has no cancellation.
            const long double centred = static_cast<long double>(value) - static_cast<long double>(offset);
            sum += centred;
            squares += centred * centred;
            return value;
        });
    }
    for (std::size_t i = buffers.size(); i-- > 1;)
        if (Status merged = buffers[0].merge(buffers[i]); !merged) return merged.error();
    const auto n = static_cast<long double>(blocks * 16);
    ProbeResult result;
    result.measured = buffers[0].resolve_variance_of_mean(0)[0] * static_cast<double>(n);
    result.expected = static_cast<double>((squares - sum * sum / n) / (n - 1));
    return result;
}

/// Returns the value of a filtered constant that is farthest from it, with importance-sampled offsets.
Result<ProbeResult> filtered_constant(const ProbeInput& input) {
    const double value = input.number("value", 0.7);
    const auto samples = static_cast<std::uint64_t>(input.number("samples", 16));
    const std::string name = input.word("filter");
    if (Status given = input.status(); !given) return given.error();
    auto filter = display::make_pixel_filter(name, {});
    if (!filter) return filter.error();
    const std::vector<ChannelDefinition> channels = one_channel(false);
    CountedNumbers numbers(3);
    ProbeResult result;
    result.measured = result.expected.emplace(value);
    int cancelled = 0;
    for (int pixel = 0; pixel < 64; ++pixel) {
        FrameBuffer buffer({1, 1}, channels);
        double weights = 0;
        feed(buffer, 0, samples, [&](std::uint64_t, display::CameraRow& row) {
            const float u = numbers.one_float(), v = numbers.one_float();
            row.filter_weight = filter->sample(u, v).weight;
            weights += double(row.filter_weight);
            return value;
        });
        // Weights of +-w that cancel exactly leave no mean.
        if (weights == 0) {
            ++cancelled;
            continue;
        }
        const double mean = buffer.resolve(0)[0];
        if (!(std::abs(mean - value) <= std::abs(result.measured - value))) result.measured = mean;
    }
    if (cancelled > 0) result.note = std::to_string(cancelled) + " of 64 pixels had weights that cancelled";
    return result;
}

/// Returns the frame buffer's estimate of its size, relative to pixels and samples counted in double.
Result<ProbeResult> buffer_bytes(const ProbeInput& input) {
    const double width = input.number("width"), height = input.number("height");
    if (Status given = input.status(); !given) return given.error();
    if (!(width >= 1 && width <= 2147483647 && height >= 1 && height <= 2147483647))
        return error_at(input.where(), "'width' or 'height' is out of range; expected 1 to 2^31 - 1");
    const std::vector<ChannelDefinition> channels = one_channel(false);
    const auto bytes_of = [&](double w, double h) {
        const auto items = display::frame_buffer_memory({static_cast<int>(w), static_cast<int>(h)}, channels);
        return static_cast<double>(display::total_bytes(items));
    };
    ProbeResult result;
    result.measured = bytes_of(width, height);
    result.expected = bytes_of(1024, 1024) / 0x1p20 * width * height;
    return result;
}

}  // namespace

std::span<const NamedProbe> sum_probes() {
    static constexpr NamedProbe table[] = {
        {"alternating_mean", "mean of a pixel whose samples alternate between a and b; a, b, samples",
         alternating_mean},
        {"sample_variance",
         "variance of a pixel's samples, offset + N(0, deviation); offset, deviation, samples (whole blocks of "
         "16), "
         "parts (merged shards), seed; expected: the variance of the samples in long double",
         sample_variance},
        {"filtered_constant", "constant image under a pixel filter, worst of 64 pixels; filter, value, samples",
         filtered_constant},
        {"buffer_bytes", "bytes of a frame buffer of one channel; width, height; expected: scaled from a small buffer",
         buffer_bytes}};
    return table;
}

}  // namespace raylex::experiments
