// Images that lights emit: linear RGB in the rendering space, row-major from the top.
#pragma once

#include <vector>

#include "transport/math/real.h"
#include "transport/math/vec.h"

namespace raylex::transport {

struct RgbImage {
    int width = 0, height = 0;
    std::vector<Rgb> pixels;

    [[nodiscard]] const Rgb& at(int x, int y) const {
        return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
    }
    /// The value at (x, y) in [0, 1]^2 from the top left corner, interpolated between the centres of four pixels.
    /// Beyond the border, the border's value.
    [[nodiscard]] Rgb bilinear(Real x, Real y) const;
    [[nodiscard]] double mean_luminance() const;
};

/// The value of a square equal-area octahedral image, interpolated between four pixel centres, across its edges too
/// (Clarberg 2008).
[[nodiscard]] Rgb octahedral_bilinear(const RgbImage& image, const Vec2& at);

}  // namespace raylex::transport
