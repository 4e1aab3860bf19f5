#include "display/output/denoise/settled_variance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace raylex::display {

namespace {

/// Means over windows inside the image, one direction after the other.
std::vector<float> window_means(const std::vector<float>& plane, int width, int height, int radius) {
    std::vector<float> rows(plane.size()), result(plane.size());
    const auto pass = [&](const std::vector<float>& from, std::vector<float>& to, int length, int step, int lines,
                          int line_step) {
        for (int line = 0; line < lines; ++line)
            for (int i = 0; i < length; ++i) {
                const int first = std::max(0, i - radius), last = std::min(length - 1, i + radius);
                float sum = 0;
                for (int k = first; k <= last; ++k) sum += from[static_cast<std::size_t>(line * line_step + k * step)];
                to[static_cast<std::size_t>(line * line_step + i * step)] = sum / static_cast<float>(last - first + 1);
            }
    };
    pass(plane, rows, width, 1, height, width);
    pass(rows, result, height, width, width, 1);
    return result;
}

/// Light that changes across pixels also changes within a pixel, and Sobol' points integrate it faster than independent
/// ones. Noise rarely makes 3 x 3 pixels differ by more than 5.5 standard errors. A larger range reduces the variance,
/// roughly by the square root of the number of samples at edges: there the variance is 1 / 18 of the squared range
/// divided by that number.
constexpr float range_of_noise = 5.5f, gain_per_range = 0.37f;

}  // namespace

void settle_variance(const std::vector<float>& values, std::vector<float>& variance, int width, int height) {
    if (width < 2 || height < 2 || variance.empty()) return;  // a single row has no neighbours in both directions
    constexpr int radius = 3;
    const auto at = [&](int x, int y) {
        return values[static_cast<std::size_t>(std::clamp(y, 0, height - 1) * width + std::clamp(x, 0, width - 1))];
    };
    std::vector<float> differences(values.size()), shown;
    // The squares of the coefficients sum to 1.5, and the least of four means of noise is 0.8 times their expectation.
    constexpr float shown_per_variance = 1.5f * 0.8f;
    constexpr std::array<std::array<int, 2>, 4> directions{{{1, 0}, {0, 1}, {1, 1}, {1, -1}}};
    for (const auto& [dx, dy] : directions) {  // an edge is smooth along itself
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                const float d = at(x, y) - 0.5f * (at(x - dx, y - dy) + at(x + dx, y + dy));
                differences[static_cast<std::size_t>(y * width + x)] = d * d / shown_per_variance;
            }
        std::vector<float> means = window_means(differences, width, height, radius);
        if (shown.empty()) shown = std::move(means);
        else
            for (std::size_t i = 0; i < shown.size(); ++i) shown[i] = std::min(shown[i], means[i]);
    }
    const std::vector<float> stated = window_means(variance, width, height, radius),
                             near = window_means(variance, width, height, 1);
    for (int y = 0, i = 0; y < height; ++y)
        for (int x = 0; x < width; ++x, ++i) {
            float least = at(x, y), most = least;
            for (int k = 0; k < 9; ++k) {
                const float other = at(x + k % 3 - 1, y + k / 3 - 1);
                least = std::min(least, other);
                most = std::max(most, other);
            }
            const auto p = static_cast<std::size_t>(i);
            variance[p] = 0.5f * (variance[p] + near[p]);
            if (shown[p] < stated[p]) variance[p] *= shown[p] / stated[p];
            if (near[p] > 0)
                variance[p] /=
                    1 + gain_per_range * std::max(0.0f, (most - least) / std::sqrt(near[p]) - range_of_noise);
        }
}

}  // namespace raylex::display
