// The metrics of `raylex compare` and of studies with their formulas: the error of an image against a reference as one
// number.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace raylex::display {

/// In every formula a is the image and b the reference; means are over all requested pixels and components.
///
/// `relmse_mean` and `trimmed_relmse_mean` are invariant to scale: doubling all light changes nothing, so they can be
/// compared across channels, scenes and exposures. Their floor is (0.1 m)^2 with m = mean(|b|): a pixel darker than a
/// tenth of the mean counts as if it had that brightness, as in adaptive sampling. `relmse` and `mape` use the floor
/// 0.01 of other tools.
enum class ErrorMetric : std::uint8_t {
    relmse,
    mse,
    mae,
    mape,
    mean_ratio,
    rmse,
    smape,
    relmse_mean,
    trimmed_relmse_mean
};
inline constexpr std::size_t error_metric_count = 9;

struct ErrorMetricInfo {
    ErrorMetric metric;
    const char* name;     ///< name in options and tables: "relmse"
    const char* formula;  ///< "mean((a-b)^2 / (b^2 + 0.01))"
};
/// All metrics, in the order of the enumeration.
std::span<const ErrorMetricInfo, error_metric_count> error_metrics();
const char* formula(ErrorMetric metric);
/// Finds a metric by name; null if there is none.
const ErrorMetricInfo* find_error_metric(std::string_view name);

/// The fraction of terms that `trimmed_relmse_mean` omits, the largest ones.
inline constexpr double trimmed_share_of_terms = 0.001;

/// All metrics of the same values. Sums are in double, in the order of the values: relative rounding error below n
/// 2^-53.
struct ErrorMeasures {
    std::array<double, error_metric_count> values{};
    double trimmed_share = 0;  ///< fraction of the sum of squared relative errors that trimming removed: 0 to 1
    double count = 0;          ///< number of compared values

    [[nodiscard]] double operator[](ErrorMetric metric) const { return values[static_cast<std::size_t>(metric)]; }
};

/// `image` and `reference` have equal length. Equal infinities (depth without a hit) count as no difference and are
/// excluded from the means of a and b. Any other value that is not finite makes metrics inf or nan; so does, for the
/// mean ratio, a mean of b that is 0. Without values the metrics are nan.
ErrorMeasures measure_errors(std::span<const double> image, std::span<const double> reference);

/// The terms of `relmse_mean` for every value: (a-b)^2 / (b^2 + (0.1 m)^2).
std::vector<double> relative_squares(std::span<const double> image, std::span<const double> reference);

/// The expected amount that unbiased noise of the reference adds to a squared metric: E[measured] = E[true] + this, for
/// mse, relmse and relmse_mean (with denominators assumed exact); nan for all other metrics, which have no such form.
/// `variance` is that of each value of `reference`.
double reference_excess(ErrorMetric metric, std::span<const double> reference, std::span<const double> variance);

}  // namespace raylex::display
