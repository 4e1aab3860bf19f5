#include "display/output/metrics/image_filters.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "display/services/elementary.h"

namespace raylex::display {

namespace {

/// Filters one line of `count` values with distance `stride`.
void filter_line(const double* from, double* to, int count, std::size_t stride, const Kernel& kernel, Border border) {
    const int radius = static_cast<int>(kernel.size() / 2);
    for (int i = 0; i < count; ++i) {
        double sum = 0;
        const int first = border == Border::nothing ? std::max(-radius, -i) : -radius;
        const int last = border == Border::nothing ? std::min(radius, count - 1 - i) : radius;
        for (int k = first; k <= last; ++k)
            sum += kernel[static_cast<std::size_t>(k + radius)] *
                   from[static_cast<std::size_t>(std::clamp(i + k, 0, count - 1)) * stride];
        to[static_cast<std::size_t>(i) * stride] = sum;
    }
}

}  // namespace

Plane filtered(const Plane& plane, const Kernel& across, const Kernel& down, Border border) {
    const auto width = static_cast<std::size_t>(plane.width);
    Plane rows(plane.width, plane.height), result(plane.width, plane.height);
    for (std::size_t y = 0; y < static_cast<std::size_t>(plane.height); ++y)
        filter_line(&plane.values[y * width], &rows.values[y * width], plane.width, 1, across, border);
    for (std::size_t x = 0; x < width; ++x)
        filter_line(&rows.values[x], &result.values[x], plane.height, width, down, border);
    return result;
}

Kernel gaussian(double deviation, int radius) {
    Kernel kernel;
    for (int x = -radius; x <= radius; ++x) kernel.push_back(elementary::exp(-0.5 * x * x / (deviation * deviation)));
    return kernel;
}

Kernel normalised(Kernel kernel) {
    const double sum = std::accumulate(kernel.begin(), kernel.end(), 0.0);
    for (double& weight : kernel) weight /= sum;
    return kernel;
}

}  // namespace raylex::display
