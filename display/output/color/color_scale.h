// Colour scales for images of numbers.
#pragma once

#include <array>
#include <span>

namespace raylex::display {

/// A position on a scale and its colour in Oklab (B. Ottosson 2020). If lightness rises monotonically, the order is
/// visible without colour vision, too.
struct ScaleAnchor {
    double at, lightness, a, b;
};

/// The 8-bit sRGB colour at a position of a scale with at least two anchors in ascending order.
std::array<unsigned char, 3> scale_color(std::span<const ScaleAnchor> scale, double position);

}  // namespace raylex::display
