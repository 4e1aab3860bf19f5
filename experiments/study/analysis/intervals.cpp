#include "experiments/study/analysis/intervals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>

#include "experiments/study/analysis/distributions.h"

namespace raylex::experiments {
namespace {

constexpr double undefined = std::numeric_limits<double>::quiet_NaN();

double plain_mean(std::span<const double> values) {
    double sum = 0;
    for (const double value : values) sum += value;
    return sum / static_cast<double>(values.size());
}

/// The logarithm of a group's product of means, with the variance of this estimate.
struct LogEstimate {
    double log_value = 0, variance = 0, degrees = 0;
    bool positive = true;
};

/// Returns the estimate from the replicates at `indices`, which may repeat.
LogEstimate log_estimate(const std::vector<Factor>& factors, std::span<const std::size_t> indices) {
    LogEstimate result;
    const auto n = static_cast<double>(indices.size());
    std::vector<double> linear(indices.size(), 0.0);
    for (const Factor& factor : factors) {
        double sum = 0;
        for (const std::size_t i : indices) sum += factor.values[i];
        const double mean = sum / n;
        if (!(mean > 0) || !std::isfinite(mean)) {
            result.positive = false;
            return result;
        }
        result.log_value += factor.power * std::log(mean);
        for (std::size_t k = 0; k < indices.size(); ++k) linear[k] += factor.power * factor.values[indices[k]] / mean;
    }
    const double center = plain_mean(linear);
    double squares = 0;
    for (const double value : linear) squares += (value - center) * (value - center);
    result.degrees = n - 1;
    result.variance = n > 1 ? squares / (n - 1) / n : undefined;
    return result;
}

std::vector<std::size_t> all_of(const std::vector<Factor>& factors) {
    std::vector<std::size_t> indices(factors.front().values.size());
    for (std::size_t i = 0; i < indices.size(); ++i) indices[i] = i;
    return indices;
}

struct Combined {
    double log_value = 0, variance = 0, degrees = 0;
};

/// Combines independent groups (Welch-Satterthwaite).
Combined combined(std::span<const LogEstimate> estimates) {
    Combined result;
    double denominator = 0;
    for (const LogEstimate& each : estimates) {
        result.log_value += each.log_value;
        result.variance += each.variance;
        denominator += each.variance * each.variance / each.degrees;
    }
    result.degrees = denominator > 0 ? result.variance * result.variance / denominator : estimates.front().degrees;
    return result;
}

/// Returns quantiles of (log theta* - log theta) / se* over resampled replicates.
std::array<double, 2> bootstrap_quantiles(std::span<const std::vector<Factor>> groups, double log_value,
                                          const IntervalOptions& options) {
    std::vector<double> statistics;
    statistics.reserve(options.resamples);
    std::vector<LogEstimate> estimates(groups.size());
    std::vector<std::size_t> indices;
    for (std::size_t resample = 0; resample < options.resamples; ++resample) {
        bool usable = true;
        for (std::size_t g = 0; g < groups.size(); ++g) {
            const std::size_t n = groups[g].front().values.size();
            indices.resize(n);
            for (std::size_t i = 0; i < n; ++i)
                // The bias of the remainder is below n / 2^64.
                indices[i] = static_cast<std::size_t>(counter_bits(options.seed, resample * groups.size() + g, i) % n);
            estimates[g] = log_estimate(groups[g], indices);
            usable = usable && estimates[g].positive;
        }
        if (!usable) continue;
        const Combined star = combined(estimates);
        if (star.variance > 0) statistics.push_back((star.log_value - log_value) / std::sqrt(star.variance));
    }
    if (statistics.size() < 20) return {undefined, undefined};
    std::sort(statistics.begin(), statistics.end());
    const auto order_statistic = [&](double p) {
        const double at = p * static_cast<double>(statistics.size() + 1) - 1;
        return statistics[static_cast<std::size_t>(
            std::clamp(std::lround(at), 0L, static_cast<long>(statistics.size()) - 1))];
    };
    const double tail = (1 - options.confidence) / 2;
    return {order_statistic(tail), order_statistic(1 - tail)};
}

std::string degrees_text(double degrees) {
    std::string text = std::to_string(std::round(degrees * 10) / 10);
    text.erase(text.find('.') + 2);
    if (text.ends_with(".0")) text.erase(text.size() - 2);
    return text;
}

}  // namespace

Interval product_interval(std::span<const std::vector<Factor>> groups, const IntervalOptions& options) {
    Interval result{undefined, undefined, undefined, {}, {}};
    std::vector<LogEstimate> estimates;
    std::size_t fewest = std::numeric_limits<std::size_t>::max();
    for (const std::vector<Factor>& group : groups) {
        const std::size_t n = group.front().values.size();
        fewest = std::min(fewest, n);
        if (n == 0) {
            result.note = "no replicates";
            return result;
        }
        estimates.push_back(log_estimate(group, all_of(group)));
        if (!estimates.back().positive) {
            result.note = "a mean is not positive and finite";
            return result;
        }
    }
    const Combined whole = combined(estimates);
    result.value = std::exp(whole.log_value);
    if (fewest < 2) {
        result.note = "one replicate";
        return result;
    }
    const double error = std::sqrt(whole.variance);
    double below = 0, above = 0;
    if (fewest >= options.bootstrap_from) {
        const std::array<double, 2> quantiles = bootstrap_quantiles(groups, whole.log_value, options);
        below = quantiles[1] * error;
        above = -quantiles[0] * error;
        result.how = "bootstrap of " + std::to_string(fewest) + " replicates";
    }
    if (fewest < options.bootstrap_from || !std::isfinite(below) || !std::isfinite(above)) {
        below = above = student_t_quantile(1 - (1 - options.confidence) / 2, whole.degrees) * error;
        result.how = "t, " + degrees_text(whole.degrees) + " degrees of freedom";
    }
    result.low = result.value * std::exp(-below);
    result.high = result.value * std::exp(above);
    return result;
}

Interval mean_interval(std::span<const double> values, const IntervalOptions& options) {
    const std::vector<Factor> group{{values, 1}};
    return product_interval(std::span(&group, 1), options);
}

Interval error_interval(std::span<const double> measured, double excess, const IntervalOptions& options) {
    Interval result = mean_interval(measured, options);
    if (!(excess > 0)) return result;
    if (result.note.empty() && result.value < 2 * excess) result.note = "at the reference's own error";
    result.value -= excess;
    result.low -= excess;
    result.high -= excess;
    return result;
}

Interval efficiency_interval(std::span<const double> squared_errors, std::span<const double> seconds,
                             const IntervalOptions& options) {
    const std::vector<Factor> group{{squared_errors, -1}, {seconds, -1}};
    return product_interval(std::span(&group, 1), options);
}

Interval speed_up_interval(const Measured& a, const Measured& b, const IntervalOptions& options) {
    const std::array<std::vector<Factor>, 2> groups{
        {{{a.squared_errors, -1}, {a.seconds, -1}}, {{b.squared_errors, 1}, {b.seconds, 1}}}};
    Interval ratio = product_interval(groups, options);
    if (ratio.high > widest_ratio * ratio.low) ratio = {undefined, undefined, undefined, wide_note, {}};
    return ratio;
}

void TailMonitor::add(std::span<const double> terms) {
    std::vector<double> positive;
    positive.reserve(terms.size());
    for (const double term : terms)
        if (term > 0) positive.push_back(term);
    count_ += static_cast<double>(positive.size());
    const auto kept = static_cast<std::size_t>(std::ceil(kept_share * static_cast<double>(positive.size())));
    const auto end = positive.begin() + static_cast<std::ptrdiff_t>(kept);
    if (end != positive.end()) std::nth_element(positive.begin(), end, positive.end(), std::greater<>());
    largest_.insert(largest_.end(), positive.begin(), end);
}

double TailMonitor::index() const {
    std::vector<double> sorted = largest_;
    std::sort(sorted.begin(), sorted.end(), std::greater<>());
    const auto count = static_cast<std::size_t>(share_of_terms * count_);
    if (count < 5 || count >= sorted.size()) return std::numeric_limits<double>::infinity();
    double logs = 0;
    for (std::size_t i = 0; i < count; ++i) logs += std::log(sorted[i] / sorted[count]);
    return logs > 0 ? static_cast<double>(count) / logs : std::numeric_limits<double>::infinity();
}

}  // namespace raylex::experiments
