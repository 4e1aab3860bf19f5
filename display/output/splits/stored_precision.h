// How far a stored value may be from the one that was meant.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <string>

#include "display/output/reader/exr_reader.h"

namespace raylex::display {

/// |stored - meant| <= unit |stored| + spacing for every way of rounding to the type, and DWA moves a value by up to
/// `dwa` on its own scale besides.
///
///   unit     one step of the type's last place: float 2^-23, half 2^-10, float packed by PXR24 2^-15. Rounding to
///            nearest costs half of that, cutting off (as some writers do) all of it.
///   spacing  of numbers too small for the type's full precision: float 2^-149, half 2^-24, PXR24 2^-141
struct StoredPrecision {
    double unit = 0, spacing = 0;
    double dwa = 0;
};

[[nodiscard]] StoredPrecision precision_of(StoredType type);
/// Header attribute of images whose filter weights may cancel: the magnitude of light that a pixel's mean can be the
/// difference of. Layers and beauty are sums in double of up to some hundred such terms, rounded each for itself: they
/// differ by up to 2^-45 of it, where neither they nor the layers' values show it.
inline constexpr const char* light_magnitude = "raylex/light_magnitude";
inline constexpr double cancelled_unit = 0x1p-45;
/// 0 where the header does not have it, or no positive number.
[[nodiscard]] double light_magnitude_of(const std::map<std::string, std::string>& attributes);
/// The largest number of the type, which writers store in place of larger ones.
[[nodiscard]] inline float largest_of(StoredType type) {
    return type == StoredType::half_float ? 65504.0f : std::numeric_limits<float>::max();
}
/// Whether a larger number may have been meant.
[[nodiscard]] inline bool is_clamped(float value, StoredType type) {
    return std::abs(value) == largest_of(type);
}
/// |sum - whole|, but for what clamped values can explain: clamped terms lower the sum, a clamped whole is too low.
[[nodiscard]] double error_beside_clamped(double sum, double whole, bool sum_is_clamped, bool whole_is_clamped);
[[nodiscard]] StoredPrecision precision_of(const ImagePlane& plane);

/// How far DWA moves a value on its own scale, x^(1/2.2) up to 1 and 1 + ln(x) / 2.2 above. It quantises the cosine
/// transform of blocks of 8 x 8 pixels, so what a value loses depends on its whole block: measured, not derived. The
/// largest move over noise, edges and gradients, half and float, DWAA and DWAB, was 0.0144 at level 45, 0.029 at 90 and
/// 0.006 at 10; the quantisation is proportional to the level, and the transform of halves has errors of its own
/// (test_display '[dwa]' -s measures again).
[[nodiscard]] double dwa_move(double level);
/// What a move of `distance` on DWA's scale changes a value by, at most.
[[nodiscard]] double dwa_change(double value, double distance);

}  // namespace raylex::display
