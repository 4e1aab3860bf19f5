// Confidence intervals for positive quantities that replicates estimate: errors, times, efficiencies, speed-ups.
//
// All are products of powers of means, theta = prod_k mean(x_k)^p_k, and live on the log scale: log theta is estimated
// with the standard error of the linearised values u_i = sum_k p_k x_ki / mean(x_k), which keeps the covariance of what
// one replicate measured (its error and its time). Ratios of two groups add variances, with Welch's degrees of freedom.
// Up to 31 replicates the quantile is Student's t; from 32 it comes from a bootstrap of the studentised statistic,
// resampling replicates.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace raylex::experiments {

/// An estimate with its interval. When `note` is not empty the interval is not to be trusted, or there is none (low and
/// high NaN), and `note` says why: "one replicate", "heavy tail, interval not valid", "at the reference's own error".
struct Interval {
    double value = 0, low = 0, high = 0;
    std::string note;
    std::string how;  ///< "t, 7 degrees of freedom", "bootstrap of 32 replicates"
    [[nodiscard]] bool valid() const { return note.empty(); }
};

/// One measured quantity of a group of replicates and the power with which its mean enters.
struct Factor {
    std::span<const double> values;
    double power = 1;
};

struct IntervalOptions {
    double confidence = 0.95;
    std::size_t bootstrap_from = 32;  ///< replicates
    std::size_t resamples = 1999;     ///< so that quantiles at 2.5 % and 97.5 % are order statistics
    std::uint64_t seed = 0;           ///< of the bootstrap: the same seed gives the same bits
};

/// The product over groups of the products of their factors. Factors of one group are of one length, value i of each
/// from replicate i; groups are independent. Means that are not positive give an interval with a note.
Interval product_interval(std::span<const std::vector<Factor>> groups, const IntervalOptions& options = {});

/// The mean of positive values.
Interval mean_interval(std::span<const double> values, const IntervalOptions& options = {});

/// The mean of measured squared errors less what the reference's noise adds in expectation (display::reference_excess).
/// The interval is that of the measured mean, shifted; it has a note where the excess is more than half of what was
/// measured.
Interval error_interval(std::span<const double> measured, double excess, const IntervalOptions& options = {});

/// 1 / (mean squared error x mean time).
Interval efficiency_interval(std::span<const double> squared_errors, std::span<const double> seconds,
                             const IntervalOptions& options = {});

/// How much more efficient `a` is than `b`.
struct Measured {
    std::span<const double> squared_errors, seconds;
};
Interval speed_up_interval(const Measured& a, const Measured& b, const IntervalOptions& options = {});

/// Watches whether the mean of a replicate's terms can have an interval at all. Feed it the terms (squared relative
/// errors) of every replicate; it compares replicates pixel by pixel, so that pixels which are always hard do not count
/// as a heavy tail.
///
/// The standard error of a replicate's error rests on the sum over values of Var(term). When a handful of values make
/// up that sum, some rare sample decides and neither t nor bootstrap covers what it says. Measured as the effective
/// number of values nu = (sum v)^2 / sum v^2 with v the terms' variance over replicates.
class TailMonitor {
  public:
    void add(std::span<const double> terms);
    /// Infinite before the second replicate and when nothing varies.
    [[nodiscard]] double effective_values() const;
    [[nodiscard]] bool heavy() const { return effective_values() < least_effective_values; }

    /// Normal noise in N equally hard values has nu about N / 15; below 20 the relative standard error of the variance
    /// itself is above sqrt(2/20) = 32 %, and a 95 % t interval can no longer be told from a 90 % one.
    static constexpr double least_effective_values = 20;

  private:
    std::vector<double> mean_, m2_;
    double count_ = 0;
};

inline constexpr const char* heavy_tail_note = "heavy tail, interval not valid";

}  // namespace raylex::experiments
