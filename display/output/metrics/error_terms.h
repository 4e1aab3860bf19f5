// The metrics of error_metrics.h value by value, for error images.
#pragma once

#include <span>
#include <vector>

#include "display/output/metrics/error_metrics.h"

namespace raylex::display {

/// The terms whose mean is the metric, value by value: for rmse the squares under its root, for trimmed_relmse_mean all
/// terms. Empty for mean_ratio, which is not such a mean. A difference of 0 gives the term 0, including 0/0.
std::vector<double> error_terms(ErrorMetric metric, std::span<const double> image, std::span<const double> reference);

}  // namespace raylex::display
