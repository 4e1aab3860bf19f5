// One plane of an image, and separable filters over it.
#pragma once

#include <cstddef>
#include <vector>

namespace raylex::display {

/// Row-major.
struct Plane {
    int width = 0, height = 0;
    std::vector<double> values;

    Plane(int columns, int rows)
        : width(columns), height(rows), values(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows)) {}
    [[nodiscard]] std::size_t size() const { return values.size(); }
};

/// The weights of the neighbours at -radius .. radius; an odd number of them.
using Kernel = std::vector<double>;

/// What stands beyond the border.
enum class Border { repeats, nothing };

/// The sum of weights times values, `across` along rows and `down` along columns. With Border::nothing what lies
/// outside counts as 0.
Plane filtered(const Plane& plane, const Kernel& across, const Kernel& down, Border border);

/// exp(-x^2 / (2 deviation^2)) for x = -radius .. radius, as it is.
Kernel gaussian(double deviation, int radius);
/// The same weights, their sum 1.
Kernel normalised(Kernel kernel);

}  // namespace raylex::display
