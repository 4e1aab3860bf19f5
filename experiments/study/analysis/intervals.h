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

inline constexpr const char* heavy_tail_note = "heavy tail, interval not valid";
/// A ratio or a time whose interval spans more than this factor is no result.
inline constexpr double widest_ratio = 100;
inline constexpr const char* wide_note = "no result: its interval spans more than a factor of 100";

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

/// How much more efficient `a` is than `b`; no value where the interval is wider than widest_ratio.
struct Measured {
    std::span<const double> squared_errors, seconds;
};
Interval speed_up_interval(const Measured& a, const Measured& b, const IntervalOptions& options = {});

/// Watches whether the mean of a replicate's terms can have an interval at all. Feed it the terms (squared relative
/// errors) of every replicate.
///
/// Fireflies undo intervals less where they are seen than where they are not: replicates that met none agree with each
/// other on too small an error. What replicates without them still show is how slowly the largest terms grow rarer:
/// Hill's estimate of the tail index alpha, P(term > t) falling as t^-alpha, from the largest 1 % of the terms that are
/// not 0. At alpha = 1 the mean itself stops to exist.
class TailMonitor {
  public:
    void add(std::span<const double> terms);
    /// Over all replicates; infinite while there are fewer than five terms to go by.
    [[nodiscard]] double index() const;
    [[nodiscard]] bool heavy() const { return index() < least_index; }

    static constexpr double share_of_terms = 0.01;
    /// Pixels of unequal difficulty alone lower the index of normal noise (infinite) to 1.3 to 1.9 in rooms of diffuse
    /// surfaces, whose intervals cover; with glass and caustics it is 0.6 to 1.1, and they cover two times in three
    /// (study_renders_test.cpp).
    static constexpr double least_index = 1.15;

  private:
    /// Of one replicate; more than its share of the largest of all, so that those of a replicate with a burst are all
    /// there.
    static constexpr double kept_share = 0.04;

    std::vector<double> largest_;
    double count_ = 0;
};

}  // namespace raylex::experiments
