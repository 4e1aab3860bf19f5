// RGB colour spaces of pbrt scenes: matrices to and from CIE XYZ, the white, and conversion between two spaces.
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "transport/color/color_context.h"

namespace raylex::transport {

using Matrix3 = std::array<std::array<double, 3>, 3>;  ///< row-major
using Triple = std::array<double, 3>;

[[nodiscard]] Triple multiply(const Matrix3& m, const Triple& v);
[[nodiscard]] Matrix3 multiply(const Matrix3& a, const Matrix3& b);
/// `m` must be regular (colour matrices are).
[[nodiscard]] Matrix3 inverse(const Matrix3& m);

/// White of a space: CIE D65, or D60 for ACES2065-1, as the spectrum that albedos are seen under.
[[nodiscard]] std::string_view white_spectrum_name(ColorSpace space);
/// XYZ of that spectrum with Y = 1, integrated with the same tables as every other spectrum, so that white is exactly
/// grey.
[[nodiscard]] Triple white_xyz(ColorSpace space);
/// From the primaries' chromaticities and white_xyz; RGB (1, 1, 1) has Y = 1.
[[nodiscard]] const Matrix3& xyz_from_rgb(ColorSpace space);
[[nodiscard]] const Matrix3& rgb_from_xyz(ColorSpace space);
/// Linear RGB of one space to another. `white_to_white`: grey stays grey when the whites differ (von Kries scaling in
/// XYZ), which is what a reflectance needs; a light keeps its XYZ instead, so the white of one space may be tinted in
/// another.
[[nodiscard]] Matrix3 rgb_from_rgb(ColorSpace to, ColorSpace from, bool white_to_white);

using Chromaticity = std::array<double, 2>;  ///< x, y
/// Of red, green and blue.
[[nodiscard]] std::array<Chromaticity, 3> primaries(ColorSpace space);
/// The space of these primaries and this white, each coordinate to a thousandth of itself as in pbrt-v4; else nothing.
[[nodiscard]] std::optional<ColorSpace> color_space_of(const std::array<Chromaticity, 3>& rgb,
                                                       const Chromaticity& white);

/// XYZ of `spectrum` under no illuminant: sums over the visible samples, unscaled.
[[nodiscard]] Triple integrate_xyz(const std::array<double, 401>& spectrum);

}  // namespace raylex::transport
