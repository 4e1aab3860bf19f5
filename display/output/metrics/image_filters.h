// One plane of an image, and separable filters for it.
#pragma once

#include <cstddef>
#include <vector>

namespace raylex::display {

/// One plane in row order.
struct Plane {
    int width = 0, height = 0;
    std::vector<double> values;

    Plane(int columns, int rows)
        : width(columns), height(rows), values(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows)) {}
    [[nodiscard]] std::size_t size() const { return values.size(); }
};

/// The weights of the neighbours at -radius .. radius; the number of weights is odd.
using Kernel = std::vector<double>;

/// The values beyond the border: the nearest value repeated, or none.
enum class Border { repeats, nothing };

/// The weighted sum of each pixel's neighbours, with `across` along rows and `down` along columns. With Border::nothing
/// neighbours outside the image count as 0.
Plane filtered(const Plane& plane, const Kernel& across, const Kernel& down, Border border);

/// exp(-x^2 / (2 deviation^2)) for x = -radius .. radius, not normalised.
Kernel gaussian(double deviation, int radius);
/// The kernel scaled to a sum of 1.
Kernel normalised(Kernel kernel);

}  // namespace raylex::display
