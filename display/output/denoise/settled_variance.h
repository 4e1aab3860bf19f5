// The variance of pixels: estimates that are less noisy than the stated ones, and hold for Sobol' points.
#pragma once

#include <vector>

namespace raylex::display {

/// Estimates of variance are as noisy as the pixels and assume independent samples. They are averaged with their
/// neighbours, and bounded by what the pixels show: Sobol' points often leave less noise than independent ones,
/// neighbouring pixels differ at least by their noise, and the variance at edges is mostly not noise. An empty plane of
/// variance stays empty.
void settle_variance(const std::vector<float>& values, std::vector<float>& variance, int width, int height);

}  // namespace raylex::display
