// Half buffers and moments: adds samples to them, and computes the layers of statistics from them.
#include "display/buffer/frame_buffer/frame_buffer_storage.h"

#include <algorithm>
#include <array>

namespace raylex::display {
namespace {

[[nodiscard]] bool is_odd(const SampleTable& table, int row) {
    return table.camera_row(row).sample % 2 != 0;
}

}  // namespace

void FrameBuffer::Storage::add_half_weights(const SampleTable& table, const Run& run) {
    for (const bool odd : {false, true}) {
        add_blocks<1>(&(odd ? odd_weight : even_weight)[run.pixel], run, layout.quantum_exponent, channels.size(),
                      [&](int first, int last) {
                          double sum = 0;
                          for (int row = first; row < last; ++row) {
                              if (is_odd(table, row) == odd) sum += run.weights[row - run.begin];
                          }
                          return std::array{sum};
                      });
        for (int row = run.begin; row < run.end; ++row)
            (odd ? odd_samples : even_samples)[run.pixel] += is_odd(table, row) == odd ? 1 : 0;
    }
}

/// `values` as in add_filtered(): component-interleaved, from the run's first row on. The halves are summed separately,
/// so that neither contains rounding errors of the other.
void FrameBuffer::Storage::add_halves(Channel& channel, std::size_t index, const SampleTable& table, const Run& run,
                                      const double* values) {
    const auto halves = [&]<std::size_t components>() {
        for (const bool odd : {false, true})
            add_blocks<components>(&(odd ? channel.odd_sum : channel.even_sum)[run.pixel * components], run,
                                   exponents[index], index, [&](int first, int last) {
                                       std::array<double, components> sum{};
                                       for (int row = first; row < last; ++row) {
                                           if (is_odd(table, row) != odd) continue;
                                           const auto at = static_cast<std::size_t>(row - run.begin);
                                           for (std::size_t c = 0; c < components; ++c)
                                               sum[c] += run.weights[at] * values[at * components + c];
                                       }
                                       return sum;
                                   });
    };
    if (channel.components == 3) halves.template operator()<3>();
    else halves.template operator()<1>();
}

std::vector<double> FrameBuffer::Storage::statistic(const Channel& source, Statistic statistic,
                                                    const PixelRegion& region) const {
    const auto components = static_cast<std::size_t>(source.components);
    const int exponent = layout.quantum_exponent, scale_exponent = source.definition.scale_exponent;
    const int value_exponent = exponent + scale_exponent;
    std::vector<double> result(display::pixel_count(region) * components);
    if (statistic == Statistic::even || statistic == Statistic::odd) {
        const bool odd = statistic == Statistic::odd;
        const Plane<Int128>&sums = odd ? source.odd_sum : source.even_sum, &weights = odd ? odd_weight : even_weight;
        const Plane<std::uint64_t>& counts = odd ? odd_samples : even_samples;
        for_each_pixel(region, layout.width, [&](std::size_t at, std::size_t pixel) {
            const Divisor divisor(weights[pixel], counts[pixel], exponent, scale_exponent);
            for (std::size_t c = 0; c < components; ++c)
                result[at * components + c] = divisor.mean_of(sums[pixel * components + c]);
        });
        return result;
    }
    for_each_pixel(region, layout.width, [&](std::size_t at, std::size_t pixel) {
        if (samples[pixel] < 2 || weight[pixel] == 0) return;
        const auto n = static_cast<long double>(samples[pixel]);
        const long double weight_sum = to_long_double(weight[pixel], exponent);
        const long double weight_squares = to_long_double(weight_square[pixel], exponent);
        const long double scale =
            statistic == Statistic::mse ? weight_squares / ((n - 1) * weight_sum * weight_sum) : 1 / (n - 1);
        for (std::size_t c = 0; c < components; ++c) {
            const std::size_t i = pixel * components + c;
            if ((source.sum[i] | source.plain_sum[i] | source.square_sum[i]) == 0) continue;
            const long double mean = to_long_double(source.sum[i], value_exponent) / weight_sum;
            // sum(v^2) is exact to 2^-56, so the only loss is the rounding of these 64-bit mantissas: 2^-63 sum(v^2).
            const long double about_mean = to_long_double(source.square_sum[i], square_exponent(source)) -
                                           mean * (2 * to_long_double(source.plain_sum[i], value_exponent) - n * mean);
            result[at * components + c] = static_cast<double>(std::max(0.0L, about_mean) * scale);
        }
    });
    return result;
}

std::vector<double> FrameBuffer::resolve_variance_of_mean(ChannelId id) const {
    return resolve_variance_of_mean(id, {0, 0, storage_->layout.width, storage_->layout.height});
}

std::vector<double> FrameBuffer::resolve_variance_of_mean(ChannelId id, const PixelRegion& region) const {
    const Channel& channel = storage_->channels[static_cast<std::size_t>(id)];
    if (channel.square_sum.empty()) return {};
    return storage_->statistic(channel, Statistic::mse, region);
}

}  // namespace raylex::display
