#include "display/output/metrics/error_metrics.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "display/output/metrics/error_terms.h"

namespace raylex::display {
namespace {

constexpr double absolute_floor = 0.01;
constexpr double relative_floor = 0.1;  // relative to m, before it is squared

constexpr std::array<ErrorMetricInfo, error_metric_count> error_metric_table{{
    {ErrorMetric::relmse, "relmse", "mean((a-b)^2 / (b^2 + 0.01))"},
    {ErrorMetric::mse, "mse", "mean((a-b)^2)"},
    {ErrorMetric::mae, "mae", "mean(|a-b|)"},
    {ErrorMetric::mape, "mape", "mean(|a-b| / (|b| + 0.01))"},
    {ErrorMetric::mean_ratio, "mean-ratio", "mean(a) / mean(b)"},
    {ErrorMetric::rmse, "rmse", "sqrt(mean((a-b)^2))"},
    {ErrorMetric::smape, "smape", "mean(2 |a-b| / (|a| + |b|)), 0/0 = 0"},
    {ErrorMetric::relmse_mean, "relmse-mean", "mean((a-b)^2 / (b^2 + (0.1 m)^2)), m = mean(|b|)"},
    {ErrorMetric::trimmed_relmse_mean, "trimmed-relmse-mean",
     "mean of (a-b)^2 / (b^2 + (0.1 m)^2) without the largest 0.1 % of terms, m = mean(|b|)"},
}};

bool same_infinity(double a, double b) {
    return std::isinf(a) && a == b;
}

double mean_magnitude(std::span<const double> values) {
    double sum = 0, count = 0;
    for (const double value : values) {
        if (std::isinf(value)) continue;
        sum += std::abs(value);
        count += 1;
    }
    return count > 0 ? sum / count : 0;
}

/// (a-b)^2 over the squared reference plus its floor. A difference of 0 gives 0, even if the reference is black
/// everywhere.
double relative_square(double difference, double reference, double floor) {
    return difference == 0 ? 0 : difference * difference / (reference * reference + floor);
}

double scaled_floor(std::span<const double> reference) {
    const double floor = relative_floor * mean_magnitude(reference);
    return floor * floor;
}

}  // namespace

std::span<const ErrorMetricInfo, error_metric_count> error_metrics() {
    return error_metric_table;
}

const char* formula(ErrorMetric metric) {
    return error_metric_table[static_cast<std::size_t>(metric)].formula;
}

const ErrorMetricInfo* find_error_metric(std::string_view name) {
    const auto found = std::find_if(error_metric_table.begin(), error_metric_table.end(),
                                    [name](const ErrorMetricInfo& each) { return name == each.name; });
    return found != error_metric_table.end() ? &*found : nullptr;
}

std::vector<double> relative_squares(std::span<const double> image, std::span<const double> reference) {
    const double floor = scaled_floor(reference);
    std::vector<double> terms(image.size(), 0.0);
    for (std::size_t i = 0; i < image.size(); ++i)
        if (!same_infinity(image[i], reference[i]))
            terms[i] = relative_square(image[i] - reference[i], reference[i], floor);
    return terms;
}

std::vector<double> error_terms(ErrorMetric metric, std::span<const double> image, std::span<const double> reference) {
    if (metric == ErrorMetric::mean_ratio) return {};
    if (metric == ErrorMetric::relmse_mean || metric == ErrorMetric::trimmed_relmse_mean)
        return relative_squares(image, reference);
    std::vector<double> terms(image.size(), 0.0);
    for (std::size_t i = 0; i < image.size(); ++i) {
        const double a = image[i], b = reference[i], magnitude = std::abs(a - b);
        if (same_infinity(a, b) || magnitude == 0) continue;
        terms[i] = metric == ErrorMetric::relmse  ? magnitude * magnitude / (b * b + absolute_floor)
                   : metric == ErrorMetric::mae   ? magnitude
                   : metric == ErrorMetric::mape  ? magnitude / (std::abs(b) + absolute_floor)
                   : metric == ErrorMetric::smape ? 2 * magnitude / (std::abs(a) + std::abs(b))
                                                  : magnitude * magnitude;  // mse, and rmse under its root
    }
    return terms;
}

ErrorMeasures measure_errors(std::span<const double> image, std::span<const double> reference) {
    double squared = 0, absolute = 0, relative_squared = 0, relative_absolute = 0, symmetric = 0, scaled = 0;
    double sum_image = 0, sum_reference = 0;
    std::vector<double> terms = relative_squares(image, reference);
    for (std::size_t i = 0; i < image.size(); ++i) {
        const double a = image[i], b = reference[i];
        if (same_infinity(a, b)) continue;
        const double difference = a - b, magnitude = std::abs(difference);
        squared += difference * difference;
        absolute += magnitude;
        relative_squared += difference * difference / (b * b + absolute_floor);
        relative_absolute += magnitude / (std::abs(b) + absolute_floor);
        if (magnitude != 0) symmetric += 2 * magnitude / (std::abs(a) + std::abs(b));
        scaled += terms[i];
        sum_image += a;
        sum_reference += b;
    }
    ErrorMeasures result;
    result.count = static_cast<double>(image.size());
    const auto set = [&result](ErrorMetric metric, double value) {
        result.values[static_cast<std::size_t>(metric)] = value;
    };
    set(ErrorMetric::relmse, relative_squared / result.count);
    set(ErrorMetric::mse, squared / result.count);
    set(ErrorMetric::mae, absolute / result.count);
    set(ErrorMetric::mape, relative_absolute / result.count);
    // An infinite reference would give 0, a ratio that other images have, too.
    set(ErrorMetric::mean_ratio,
        std::isfinite(sum_reference) ? sum_image / sum_reference : std::numeric_limits<double>::quiet_NaN());
    set(ErrorMetric::rmse, std::sqrt(squared / result.count));
    set(ErrorMetric::smape, symmetric / result.count);
    set(ErrorMetric::relmse_mean, scaled / result.count);

    // The largest come first. Values that are not finite cannot be sorted and are never trimmed, so they remain
    // visible.
    const auto trimmed = static_cast<std::size_t>(trimmed_share_of_terms * static_cast<double>(terms.size()));
    double kept = scaled, left_out = 0;
    if (trimmed > 0 && std::isfinite(scaled)) {
        const auto middle = terms.begin() + static_cast<std::ptrdiff_t>(trimmed);
        std::nth_element(terms.begin(), middle, terms.end(), std::greater<>());
        // The order that nth_element leaves depends on the library; sums of sorted values have the same bits
        // everywhere.
        std::sort(terms.begin(), middle, std::greater<>());
        for (auto term = terms.begin(); term != middle; ++term) left_out += *term;
        kept = std::max(0.0, scaled - left_out);
    }
    set(ErrorMetric::trimmed_relmse_mean, kept / (result.count - static_cast<double>(trimmed)));
    result.trimmed_share = scaled > 0 ? left_out / scaled : 0;
    return result;
}

double reference_excess(ErrorMetric metric, std::span<const double> reference, std::span<const double> variance) {
    if (metric != ErrorMetric::mse && metric != ErrorMetric::relmse && metric != ErrorMetric::relmse_mean)
        return std::numeric_limits<double>::quiet_NaN();
    const double floor = metric == ErrorMetric::relmse ? absolute_floor : scaled_floor(reference);
    double sum = 0;
    for (std::size_t i = 0; i < reference.size(); ++i) {
        if (variance[i] == 0) continue;
        sum += metric == ErrorMetric::mse ? variance[i] : variance[i] / (reference[i] * reference[i] + floor);
    }
    return sum / static_cast<double>(reference.size());
}

}  // namespace raylex::display
