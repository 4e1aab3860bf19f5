// The variance of pixels: estimates that are less noisy than the stated ones, and hold for Sobol' points.
#pragma once

#include <vector>

namespace raylex::display {

/// Replaces stated variances, which assume independent samples, by estimates with less noise. Averages the variances of
/// neighbours, limits them to the squared differences of neighbouring values, which include all noise, and reduces the
/// variance at edges, where Sobol' points leave less noise. `values` and `variance` have width x height elements, row
/// by row. An empty plane of variance stays empty.
void settle_variance(const std::vector<float>& values, std::vector<float>& variance, int width, int height);

}  // namespace raylex::display
