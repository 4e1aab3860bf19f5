// Scales of colour for pictures of numbers.
#pragma once

#include <array>
#include <span>

namespace raylex::display {

/// A place on a scale and its colour in Oklab (B. Ottosson 2020). Scales whose lightness rises all along tell the order
/// also without colour vision.
struct ScaleAnchor {
    double at, lightness, a, b;
};

/// 8-bit sRGB at a position of a scale: at least two anchors, their places ascending.
std::array<unsigned char, 3> scale_color(std::span<const ScaleAnchor> scale, double position);

}  // namespace raylex::display
