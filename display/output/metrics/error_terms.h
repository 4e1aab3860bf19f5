// Metrics of error_metrics.h value by value, for images of errors.
#pragma once

#include <span>
#include <vector>

#include "display/output/metrics/error_metrics.h"

namespace raylex::display {

/// What the metric is the mean of, value by value: for rmse the squares under its root, for trimmed_relmse_mean all
/// terms. Empty for mean_ratio, which is no such mean. No difference is no term, 0/0 included.
std::vector<double> error_terms(ErrorMetric metric, std::span<const double> image, std::span<const double> reference);

}  // namespace raylex::display
