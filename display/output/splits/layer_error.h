// Compares a sum of layers with the layer that it splits. The bounds of rounding and lossy compression are propagated
// through the arithmetic (forward error analysis).
#pragma once

#include "display/output/splits/layer_arithmetic.h"
#include "display/output/splits/split_check.h"

namespace raylex::display {

struct SumRules {
    /// Relative rounding error of one addition or product in the writer: 2^-24 in float, 0 where sums are exact.
    double working_unit = 0x1p-24;
    double cancelled = 0;  ///< rounding error of samples whose weights cancel: see stored_precision.h
    Allowance allowance;
};

/// Compares the sum with `of`. Errors: layers of unsigned integers, or with planes that are neither R G B nor X Y Z nor
/// a single one.
Result<SplitResult> check_sum(const ExrImage& image, const ImageLayer& of, const LayerSum& sum, const SumRules& rules);

}  // namespace raylex::display
