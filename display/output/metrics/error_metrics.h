// How far an image is from a reference, in one number: the metrics of `raylex compare` and of studies, with their
// formulas.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace raylex::display {

/// In every formula a is the image, b the reference, and means run over all pixels and components that are asked for.
///
/// `relmse_mean` and `trimmed_relmse_mean` are free of scale: doubling all light changes nothing, so that they compare
/// across channels, scenes and exposures. Their floor is (0.1 m)^2 with m = mean(|b|): a pixel darker than a tenth of
/// the mean counts as if it were that bright, as in adaptive sampling. `relmse` and `mape` carry the floor 0.01 that
/// other tools use.
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
    const char* name;     ///< as options and tables write it: "relmse"
    const char* formula;  ///< "mean((a-b)^2 / (b^2 + 0.01))"
};
/// All of them, in the order of the enumeration.
std::span<const ErrorMetricInfo, error_metric_count> error_metrics();
const char* formula(ErrorMetric metric);
/// Null when there is no metric of this name.
const ErrorMetricInfo* find_error_metric(std::string_view name);

/// The share of terms that `trimmed_relmse_mean` leaves out, the largest ones.
inline constexpr double trimmed_share_of_terms = 0.001;

/// Every metric of the same values. Sums in double, in the order of the values: relative rounding error below n 2^-53.
struct ErrorMeasures {
    std::array<double, error_metric_count> values{};
    double trimmed_share = 0;  ///< of the whole sum of squared relative errors, what trimming left out: 0 to 1
    double count = 0;          ///< values that were compared

    [[nodiscard]] double operator[](ErrorMetric metric) const { return values[static_cast<std::size_t>(metric)]; }
};

/// `image` and `reference` are of one length. Equal infinities (depth where nothing was hit) count as no difference and
/// stay out of the means of a and b; any other value that is not finite makes metrics inf or nan, and so does a mean of
/// b that is 0 the mean ratio. No values at all: nan.
ErrorMeasures measure_errors(std::span<const double> image, std::span<const double> reference);

/// The terms of `relmse_mean`: (a-b)^2 / (b^2 + (0.1 m)^2) of every value.
std::vector<double> relative_squares(std::span<const double> image, std::span<const double> reference);

/// What unbiased noise of the reference adds to a squared metric, in expectation: E[measured] = E[true] + this, for
/// mse, relmse and relmse_mean (denominators taken as exact); nan for all others, whose excess has no such form.
/// `variance` is that of each value of `reference`.
double reference_excess(ErrorMetric metric, std::span<const double> reference, std::span<const double> variance);

}  // namespace raylex::display
