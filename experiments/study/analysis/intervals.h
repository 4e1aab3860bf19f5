// Confidence intervals of positive quantities from replicates: errors, times, efficiencies, speed-ups.
//
// All are products of powers of means, theta = prod_k mean(x_k)^p_k, on the log scale. The standard error of log theta
// is that of the linearised values u_i = sum_k p_k x_ki / mean(x_k), which includes the covariance of the measurements
// of one replicate (its error and its time). A ratio of two groups adds their variances, with Welch's degrees of
// freedom. Up to 31 replicates the quantile is Student's t; from 32 on it comes from a bootstrap of the studentised
// statistic over replicates.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace raylex::experiments {

/// An estimate with its interval. If `note` is not empty, the interval is invalid or missing (low and high NaN), and
/// `note` is the reason: "one replicate", "heavy tail, interval not valid", "at the reference's own error".
struct Interval {
    double value = 0, low = 0, high = 0;
    std::string note;
    std::string how;  ///< "t, 7 degrees of freedom", "bootstrap of 32 replicates"
    [[nodiscard]] bool valid() const { return note.empty(); }
};

inline constexpr const char* heavy_tail_note = "heavy tail, interval not valid";
/// A ratio or time whose interval spans more than this factor is not a result.
inline constexpr double widest_ratio = 100;
inline constexpr const char* wide_note = "no result: the interval spans more than a factor of 100";

/// A measured quantity of a group of replicates, and the power of its mean in the product.
struct Factor {
    std::span<const double> values;
    double power = 1;
};

struct IntervalOptions {
    double confidence = 0.95;
    std::size_t bootstrap_from = 32;  ///< number of replicates
    std::size_t resamples = 1999;     ///< makes quantiles at 2.5 % and 97.5 % order statistics
    std::uint64_t seed = 0;           ///< of the bootstrap; equal seeds give equal bits
};

/// Returns the product over groups of the products of their factors. Factors of a group have equal length; value i of
/// each comes from replicate i. Groups are independent. Means that are not positive give an interval with a note.
Interval product_interval(std::span<const std::vector<Factor>> groups, const IntervalOptions& options = {});

/// Returns the mean of positive values.
Interval mean_interval(std::span<const double> values, const IntervalOptions& options = {});

/// Returns the mean of measured squared errors minus the expected contribution of the reference's noise
/// (display::reference_excess). The interval is that of the measured mean, shifted; it has a note if the excess is more
/// than half of the measured error.
Interval error_interval(std::span<const double> measured, double excess, const IntervalOptions& options = {});

/// Returns 1 / (mean squared error x mean time).
Interval efficiency_interval(std::span<const double> squared_errors, std::span<const double> seconds,
                             const IntervalOptions& options = {});

/// Returns the ratio of the efficiencies of `a` and `b`; no value if the interval is wider than widest_ratio.
struct Measured {
    std::span<const double> squared_errors, seconds;
};
Interval speed_up_interval(const Measured& a, const Measured& b, const IntervalOptions& options = {});

/// Checks whether the mean of a replicate's terms can have a confidence interval. Its input is the terms (squared
/// relative errors) of every replicate.
///
/// Fireflies invalidate intervals most where they are absent: replicates without any agree on an error that is too
/// small. But the largest terms show how quickly the tail decreases: Hill's estimate of the tail index alpha, with
/// P(term > t) falling as t^-alpha, uses the largest 1 % of the non-zero terms. At alpha = 1 the mean does not exist.
class TailMonitor {
  public:
    void add(std::span<const double> terms);
    /// Returns the index over all replicates; infinite with fewer than five usable terms.
    [[nodiscard]] double index() const;
    [[nodiscard]] bool heavy() const { return index() < least_index; }

    static constexpr double share_of_terms = 0.01;
    /// Limit of a valid index. Normal noise has index infinity. Pixels of unequal difficulty lower it to 1.3 to 1.9 in
    /// diffuse rooms, where intervals are valid; with glass and caustics it is 0.6 to 1.1, and intervals cover two
    /// times in three (study_renders_test.cpp).
    static constexpr double least_index = 1.15;

  private:
    /// Fraction of terms kept per replicate. It is larger than the fraction used, so that all large terms of a
    /// replicate with a burst are kept.
    static constexpr double kept_share = 0.04;

    std::vector<double> largest_;
    double count_ = 0;
};

}  // namespace raylex::experiments
