// The possible distance of a stored value from the true value.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <string>

#include "display/output/reader/exr_reader.h"

namespace raylex::display {

/// |stored - true| <= unit |stored| + spacing for every way of rounding to the type. In addition DWA moves a value by
/// up to `dwa` on its own scale.
///
///   unit     one unit in the last place of the type: float 2^-23, half 2^-10, float packed by PXR24 2^-15. Rounding
///             to nearest costs half of that, truncation (in some writers) all of it.
///   spacing  for numbers too small for the type's full precision: float 2^-149, half 2^-24, PXR24 2^-141
struct StoredPrecision {
    double unit = 0, spacing = 0;
    double dwa = 0;
};

[[nodiscard]] StoredPrecision precision_of(StoredType type);
/// Header attribute of images whose filter weights can cancel: the magnitude of light whose difference can be a pixel's
/// mean. Layers and beauty are sums in double of up to some hundred such terms, each rounded separately. So they can
/// differ by up to 2^-45 of this magnitude, which their values do not show.
inline constexpr const char* light_magnitude = "raylex/light_magnitude";
inline constexpr double cancelled_unit = 0x1p-45;
/// The attribute's value; 0 if the header lacks it, or if it is not a positive number.
[[nodiscard]] double light_magnitude_of(const std::map<std::string, std::string>& attributes);
/// The largest number of the type; writers store it instead of larger ones.
[[nodiscard]] inline float largest_of(StoredType type) {
    return type == StoredType::half_float ? 65504.0f : std::numeric_limits<float>::max();
}
/// Returns whether the true value can be larger.
[[nodiscard]] inline bool is_clamped(float value, StoredType type) {
    return std::abs(value) == largest_of(type);
}
/// |sum - whole|, minus what clamped values can explain: clamped terms lower the sum, and a clamped whole is too low.
[[nodiscard]] double error_of_clamped(double sum, double whole, bool sum_is_clamped, bool whole_is_clamped);
[[nodiscard]] StoredPrecision precision_of(const ImagePlane& plane);

/// The distance by which DWA moves a value on its own scale, which is x^(1/2.2) up to 1 and 1 + ln(x) / 2.2 above. DWA
/// quantises the cosine transform of blocks of 8 x 8 pixels, so the loss of a value depends on its whole block; it is
/// measured, not derived. The largest move over noise, edges and gradients, half and float, DWAA and DWAB, was 0.0144
/// at level 45, 0.029 at 90 and 0.006 at 10. The quantisation is proportional to the level, and the transform of halves
/// has errors of its own (test_display '[dwa]' -s repeats the measurement).
[[nodiscard]] double dwa_move(double level);
/// The largest change of a value that a move of `distance` on DWA's scale causes.
[[nodiscard]] double dwa_change(double value, double distance);

}  // namespace raylex::display
