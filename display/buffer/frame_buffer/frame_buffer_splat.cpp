// Splat mode: samples are distributed evenly over the image, and the kernel weights each for all pixels in its reach.
//
// The contribution of one block of one neighbour to a pixel is summed in double, in sample order, and added exactly.
// So, as in importance mode, sums do not depend on any other order (Law 3).
#include "display/buffer/frame_buffer/frame_buffer_storage.h"

#include <array>

namespace raylex::display {

void SplatWeights::gather(const SampleTable& table, const PixelFilter& kernel, const FrameBufferLayout& layout,
                          int begin, int end) {
    pixels.clear();
    weights.clear();
    count = static_cast<std::size_t>(end - begin);
    const CameraRow& first = table.camera_row(begin);
    const int reach_x = splat_reach(kernel.radius_x()), reach_y = splat_reach(kernel.radius_y());
    for (int y = std::max(0, first.pixel_y - reach_y); y <= std::min(layout.height - 1, first.pixel_y + reach_y); ++y)
        for (int x = std::max(0, first.pixel_x - reach_x); x <= std::min(layout.width - 1, first.pixel_x + reach_x);
             ++x) {
            bool any = false;
            for (int row = begin; row < end; ++row) {
                const CameraRow& camera = table.camera_row(row);
                const float weight = kernel.evaluate(camera.screen_x - (static_cast<float>(x) + 0.5f),
                                                     camera.screen_y - (static_cast<float>(y) + 0.5f));
                weights.push_back(static_cast<double>(weight));
                any = any || weight != 0;
            }
            if (any) {
                pixels.push_back(static_cast<std::size_t>(y) * static_cast<std::size_t>(layout.width) +
                                 static_cast<std::size_t>(x));
            } else {
                weights.resize(weights.size() - count);
            }
        }
}

/// Adds weight and alpha of the run to every pixel in reach.
void FrameBuffer::Storage::splat_weights(const Run& run) {
    for (std::size_t target = 0; target < run.splat->pixels.size(); ++target) {
        const double* w = run.splat->of(target);
        double sum = 0, weighted_alpha = 0;
        for (std::size_t i = 0; i < run.splat->count; ++i) {
            sum += w[i];
            weighted_alpha += w[i] * run.alpha[static_cast<std::size_t>(run.begin) + i];
        }
        const std::size_t pixel = run.splat->pixels[target];
        add(weight, pixel, &sum, 1, layout.quantum_exponent, channels.size());
        if (weighted_alpha != 0) add(alpha, pixel, &weighted_alpha, 1, layout.quantum_exponent, channels.size());
    }
}

/// `values` as in add_filtered(): component-interleaved, from the run's first row on.
void FrameBuffer::Storage::splat_values(Channel& channel, std::size_t index, const Run& run, const double* values) {
    const auto components = static_cast<std::size_t>(channel.components);
    for (std::size_t target = 0; target < run.splat->pixels.size(); ++target) {
        const double* w = run.splat->of(target);
        std::array<double, 3> sum{};
        for (std::size_t i = 0; i < run.splat->count; ++i)
            for (std::size_t c = 0; c < components; ++c) sum[c] += w[i] * values[i * components + c];
        if (sum != std::array<double, 3>{})
            add(channel.sum, run.splat->pixels[target] * components, sum.data(), channel.components, exponents[index],
                index);
    }
}

}  // namespace raylex::display
