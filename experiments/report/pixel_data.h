// Pixels inside a page, packed so that a browser can unpack them without any library (pixels.js).
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "display/output/color/color_manager.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// base64(zlib(bytes of half floats)). The high bytes of all values come first, each as its difference from the one
/// before (mod 256); the low bytes follow. Finite values beyond the range of half floats (65504) are clamped. NaN and
/// infinities stay.
std::string pack_halves(std::span<const float> values);
/// base64(zlib(bytes of integers)) for integers from 0 to 2^32 - 1, in four planes of bytes, the highest byte first.
/// Any other value becomes 0.
std::string pack_integers(std::span<const float> values);
/// base64(zlib(bytes)).
std::string pack_bytes(std::span<const unsigned char> bytes);

/// A view of the colour config as a lookup table, so that the page can change the exposure itself. The table has 8-bit
/// RGB for view_nodes^3 linear colours, red fastest. Node i of a component is the value 2^(i / 2 - 10) - 2^-10, from 0
/// to 128. One node is 1 up to 1 part in 1000, so a curve that clips at 1 is reproduced.
inline constexpr std::size_t view_nodes = 35;
Result<std::string> pack_view(const display::ColorManager& color, const display::Chromaticities& primaries,
                              const std::string& display, const std::string& view);

}  // namespace raylex::experiments
