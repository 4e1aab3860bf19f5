// Conversions between linear RGB spaces that are given by their chromaticities.
#pragma once

#include <array>

#include "display/output/image_types.h"

namespace raylex::display {

/// Row-major; multiplies column vectors.
using Matrix3 = std::array<std::array<double, 3>, 3>;

[[nodiscard]] Matrix3 identity_matrix();
[[nodiscard]] Matrix3 multiply(const Matrix3& a, const Matrix3& b);  ///< applies b, then a
/// The inverse by the adjugate; a singular matrix (collinear primaries) gives the zero matrix.
[[nodiscard]] Matrix3 inverse(const Matrix3& m);
[[nodiscard]] std::array<double, 3> transform_colour(const Matrix3& m, const std::array<double, 3>& colour);

/// Linear RGB to CIE XYZ; RGB (1, 1, 1) becomes the white with Y = 1 (SMPTE RP 177-1993, section 3.3).
[[nodiscard]] Matrix3 rgb_to_xyz(const Chromaticities& primaries);
/// Adapts XYZ from one white to another by the linear Bradford transform (Lam 1985; ICC.1:2022, annex E.3).
[[nodiscard]] Matrix3 bradford(const std::array<double, 2>& from_white, const std::array<double, 2>& to_white);
/// Linear RGB to XYZ adapted to D65 (0.3127, 0.3290).
[[nodiscard]] Matrix3 rgb_to_xyz_d65(const Chromaticities& primaries);
/// Linear RGB to linear RGB, with whites adapted by Bradford. Exactly the identity for `equivalent` primaries.
[[nodiscard]] Matrix3 rgb_to_rgb(const Chromaticities& from, const Chromaticities& to);

/// Returns whether the primaries are equal up to rounding in files (every coordinate within 1e-4).
[[nodiscard]] bool equivalent(const Chromaticities& a, const Chromaticities& b);
/// The weights of R, G, B in relative luminance; for Rec. 709 the four digits of the standard (0.2126, 0.7152, 0.0722).
[[nodiscard]] std::array<double, 3> luminance_weights(const Chromaticities& primaries);

/// Published primaries: ITU-R BT.709, BT.2020, SMPTE EG 432-1 (P3-D65), Adobe RGB (1998), SMPTE ST 2065-1 (AP0),
/// S-2014-004 (AP1).
[[nodiscard]] Chromaticities rec709_primaries();
[[nodiscard]] Chromaticities rec2020_primaries();
[[nodiscard]] Chromaticities p3d65_primaries();
[[nodiscard]] Chromaticities adobe_rgb_primaries();
[[nodiscard]] Chromaticities aces_ap0_primaries();
[[nodiscard]] Chromaticities aces_ap1_primaries();

}  // namespace raylex::display
