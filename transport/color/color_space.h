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
/// The inverse of `m`, which must be regular (colour matrices are).
[[nodiscard]] Matrix3 inverse(const Matrix3& m);

/// The name of the white spectrum of a space, under which albedos are seen: CIE D65, or D60 for ACES2065-1.
[[nodiscard]] std::string_view white_spectrum_name(ColorSpace space);
/// XYZ of the white spectrum with Y = 1, integrated with the same tables as every other spectrum, so that white is
/// exactly grey.
[[nodiscard]] Triple white_xyz(ColorSpace space);
/// The matrix from the primaries' chromaticities and white_xyz(); RGB (1, 1, 1) has Y = 1.
[[nodiscard]] const Matrix3& xyz_from_rgb(ColorSpace space);
[[nodiscard]] const Matrix3& rgb_from_xyz(ColorSpace space);
/// Converts linear RGB of one space to another. With `white_to_white`, grey stays grey where the whites differ (von
/// Kries scaling in XYZ), as reflectances need. Without it a light keeps its XYZ, so the white of one space may be
/// tinted in another.
[[nodiscard]] Matrix3 rgb_from_rgb(ColorSpace to, ColorSpace from, bool white_to_white);

using Chromaticity = std::array<double, 2>;  ///< x, y
/// Chromaticities of red, green and blue.
[[nodiscard]] std::array<Chromaticity, 3> primaries(ColorSpace space);
/// The space with these primaries and this white, where each coordinate agrees to a thousandth of itself as in pbrt-v4;
/// else nothing.
[[nodiscard]] std::optional<ColorSpace> color_space_of(const std::array<Chromaticity, 3>& rgb,
                                                       const Chromaticity& white);

/// XYZ of `spectrum` under no illuminant: sums over the visible samples, unscaled.
[[nodiscard]] Triple integrate_xyz(const std::array<double, 401>& spectrum);

}  // namespace raylex::transport
