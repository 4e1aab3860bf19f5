// How far a stored value may be from the one that was meant.
#pragma once

#include <cstdint>

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
