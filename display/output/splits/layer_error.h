// A sum of layers against the layer it splits, with what rounding and lossy compression may cost carried through the
// arithmetic (forward error analysis).
#pragma once

#include "display/output/splits/layer_arithmetic.h"
#include "display/output/splits/split_check.h"

namespace raylex::display {

struct SumRules {
    /// What one addition or product costs whoever made the image, relative: 2^-24 in float, 0 where sums are exact.
    double working_unit = 0x1p-24;
    double cancelled = 0;  ///< what rounding of samples costs whose weights cancel: stored_precision.h
    Allowance allowance;
};

/// Errors: layers of unsigned integers, or of planes that are neither R G B nor X Y Z nor a single one.
Result<SplitVerdict> judge_sum(const ExrImage& image, const ImageLayer& of, const LayerSum& sum, const SumRules& rules);

}  // namespace raylex::display
