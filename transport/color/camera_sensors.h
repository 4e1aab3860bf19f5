// Sensors of cameras as pbrt-v4 has them, as matrices: what their spectral responses make of XYZ.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "transport/color/color_space.h"

namespace raylex::transport {

/// By pbrt-v4's names, sorted.
[[nodiscard]] const std::vector<std::string>& camera_sensors();

/// Below this temperature camera_sensor() is what it is there.
inline constexpr double camera_sensor_coldest = 2500;

/// What the sensor called `name`, balanced for `kelvin`, records other than cie1931 does: from XYZ that Bradford's
/// responses have taken from the white of `kelvin` to D65, to XYZ on a film of `space`, both with Y = 1 for light of
/// the scene with Y = 1, exposure aside. Nothing for other names.
///
/// Source: spectral responses, swatches and method of pbrt-v4 (github.com/mmp/pbrt-v4: src/pbrt/util/spectrum.cpp,
/// src/pbrt/film.{h,cpp}, PixelSensor), which solves for XYZ from a sensor's RGB over 24 swatches under daylight of
/// `kelvin`, below 4000 K a blackbody. The matrices here are least squares over what that records of 9 blackbodies
/// (2500 to 6500 K) and 9 daylights (4000 to 10000 K), weight 1, and of D65, D50 and blackbodies of 2856 and 4000 K
/// times each swatch, weight 0.05, all with Y = 1 (before the swatch); they are exact for D65, sRGB's white. Between
/// the temperatures of the table they are linear in 1 / kelvin, with an error within 0.13 %.
///
/// Residuals over those 18 lights and 17 cameras, at 2500 to 10000 K: Y 0.2 % on average and 0.8 % at most, channels of
/// sRGB 0.4 % and 2.3 % of the brightest (cie1931 alone, at 6500 and 5000 K: Y 1.1 % and 1.4 %, at most 5.5 %, channels
/// 1.4 % and 2.8 %, at most 8.5 %). The swatches under the light that the sensor is balanced for, as products of RGB,
/// differ by 2 % to 5 % of the brightest channel on average and 16 % at most, as with cie1931: that is what RGB cannot
/// know of their spectra.
[[nodiscard]] std::optional<Matrix3> camera_sensor(std::string_view name, double kelvin, ColorSpace space);

}  // namespace raylex::transport
