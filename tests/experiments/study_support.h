// Results directories like those of `raylex experiment run`, made from known values instead of renders.
#pragma once

#include <string>

#include "experiments/study/results.h"
#include "support.h"

namespace raylex::test {

struct SyntheticStudy {
    int width = 64, height = 48;
    int scenes = 1;
    int budgets = 4;  ///< 16, 32, ... samples per pixel
    int replicates = 5;
    int channels = 3;    ///< beauty, then channels by bounce whose sum it is: 1, 2, ... scatterings
    int variants = 3;    ///< path; skewed, whose two-bounce light is 5 % too bright; clamped, declared biased, 10 % too
                         ///< dark; more paths
    double noise = 0.4;  ///< standard deviation of one sample relative to its pixel
};

/// Writes the study below `folder` and reads it back. One more cell has failed, one is missing.
experiments::Experiment write_synthetic_study(const Folder& folder, const SyntheticStudy& study);

}  // namespace raylex::test
