// Pixels inside a page: packed so that pixels.js unpacks them in a browser without any library.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "display/output/color/color_manager.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// base64(zlib(halves)): of each value's two bytes all high ones first, each less the one before (mod 256), then all
/// low ones. Finite values beyond the range of half floats (65504) are clamped to it; NaN and infinities stay.
std::string pack_halves(std::span<const float> values);
/// The same for whole numbers from 0 to 2^32 - 1, in four planes of bytes, the highest first. Anything else becomes 0.
std::string pack_integers(std::span<const float> values);
/// base64(zlib(bytes)).
std::string pack_bytes(std::span<const unsigned char> bytes);

/// A view of the colour config as a table that the page looks colours up in, so that exposure can be chosen there:
/// 8-bit RGB at view_nodes^3 linear colours, red fastest; node i of a component is the value 2^(i / 2 - 10) - 2^-10,
/// from 0 to 128, and 1 is a node to 1 part in 1000, so that a curve that clips there is followed.
inline constexpr std::size_t view_nodes = 35;
Result<std::string> pack_view(const display::ColorManager& color, const display::Chromaticities& primaries,
                              const std::string& display, const std::string& view);

}  // namespace raylex::experiments
