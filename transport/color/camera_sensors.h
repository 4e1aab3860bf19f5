// pbrt-v4's camera sensors as matrices, which apply their spectral responses to XYZ.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "transport/color/color_space.h"

namespace raylex::transport {

/// The names of all sensors, pbrt-v4's, sorted.
[[nodiscard]] const std::vector<std::string>& camera_sensors();

/// Temperature in kelvin below which camera_sensor() returns the matrix of this temperature.
inline constexpr double camera_sensor_coldest = 2500;

/// The matrix by which the sensor `name`, balanced for `kelvin`, differs from cie1931. It takes XYZ that Bradford's
/// responses have adapted from the white of `kelvin` to D65, to XYZ on a film of `space`. Light of the scene with Y = 1
/// has Y = 1 on both sides, apart from exposure. Returns nothing for unknown names.
///
/// Source: spectral responses, swatches and method of pbrt-v4 (github.com/mmp/pbrt-v4: src/pbrt/util/spectrum.cpp,
/// src/pbrt/film.{h,cpp}, PixelSensor), which solves for XYZ from a sensor's RGB over 24 swatches under daylight of
/// `kelvin` (below 4000 K: a blackbody). The matrices here are least-squares fits to the recordings of 9 blackbodies
/// (2500 to 6500 K) and 9 daylights (4000 to 10000 K) with weight 1, and of D65, D50 and blackbodies of 2856 and 4000 K
/// times each swatch with weight 0.05, all with Y = 1 (before the swatch). They are exact for D65, the white of sRGB.
/// Between the temperatures of the table they are linear in 1 / kelvin, with an error of at most 0.13 %.
///
/// Residuals over those 18 lights and 17 cameras, at 2500 to 10000 K: Y 0.2 % on average and 0.8 % at most, channels of
/// sRGB 0.4 % and 2.3 % of the brightest (cie1931 alone, at 6500 and 5000 K: Y 1.1 % and 1.4 %, at most 5.5 %, channels
/// 1.4 % and 2.8 %, at most 8.5 %). The swatches under the light for which the sensor is balanced, as products of RGB,
/// differ by 2 % to 5 % of the brightest channel on average and 16 % at most, as with cie1931: RGB does not contain
/// their spectra.
[[nodiscard]] std::optional<Matrix3> camera_sensor(std::string_view name, double kelvin, ColorSpace space);

}  // namespace raylex::transport
