// The decrease of an error: fitted slopes, the time to an error, and predictions of later budgets from earlier ones.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "experiments/study/analysis/intervals.h"

namespace raylex::experiments {

/// All replicates of a variant at one budget. Errors are squared relative errors minus the reference's noise.
struct BudgetGroup {
    double budget = 0;
    std::vector<double> errors;   ///< one per replicate
    std::vector<double> seconds;  ///< wall time of everything
    std::vector<double> samples;  ///< per pixel; 0 if unknown
    double setup_seconds = 0;     ///< mean time that does not grow with the budget: loading, building, pre-passes
    bool at_floor = false;        ///< the reference's noise is more than half of the measured error
    bool heavy_tail = false;
};

enum class Against { seconds, samples };

/// log e = intercept + slope log x, by ordinary least squares over replicates, with Student's t on the residuals. Both
/// the scatter of replicates and a lack of fit widen the interval.
struct Line {
    double intercept = 0, slope = 0;
    double slope_low = 0, slope_high = 0;
    double residual = 0;         ///< standard deviation of one replicate from the line, in log units
    double mean_x = 0, sxx = 0;  ///< of log x
    double count = 0, degrees = 0;
    double least_x = 0, most_x = 0;
};

inline constexpr double slope_octaves = 4;

/// Fits a line through the budgets within `octaves` of the largest one above the reference's floor. Returns nothing
/// with fewer than two budgets or fewer than three replicates with positive errors, or if x is unknown.
std::optional<Line> fit_line(std::span<const BudgetGroup> groups, Against against, double octaves = slope_octaves,
                             double confidence = 0.95);

struct SlopeTest {
    std::optional<Line> seconds, samples;
    bool too_shallow = false;  ///< declared unbiased, and persistently shallower than -1 at the last octaves
    bool nears = false;        ///< shallower than -1 but approaching it, as in a start-up
    std::string text;          ///< a phrase for the table: "-1 is in the interval", "too shallow: ..."
    /// The line that is judged: against samples if they are known, because times also depend on the load of the
    /// machine.
    [[nodiscard]] const std::optional<Line>& checked() const { return samples ? samples : seconds; }
};
/// Judges the slope of a method. The error of a method with a start-up (chains that warm up, guides that learn) falls
/// more slowly at first, and its slope approaches -1 with every octave; the slope of a biased method moves away from
/// -1. A method is too shallow if its slopes over the last four and the last two octaves are above -0.98, and the
/// latter is farther from -1 than half of the slope before (all at 95 %) and not closer by a standard error. This needs
/// four budgets over more than two octaves, with three replicates each.
SlopeTest test_slope(std::span<const BudgetGroup> groups, bool declared_unbiased);

/// The time at which the relative error (the root of the squared error) is `relative_error`.
struct TimeToError {
    double relative_error = 0;
    Interval seconds;           ///< NaN with a note if the error is never reached
    bool extrapolated = false;  ///< outside the measured times
};

/// Estimates the time to an error. Within the measured budgets, uses a line through those within an octave of the
/// target's bracket; outside, the last (or first) four octaves with slope -1, unless the fitted 99 % interval excludes
/// it. x is the number of samples per pixel if known, with the cost per sample of the nearest large budget; otherwise
/// the time without setup. The setup time is added again. Intervals use the delta method. Times beyond 2^10 times the
/// measured ones, and times with an interval wider than widest_ratio, are not given.
TimeToError time_to_error(std::span<const BudgetGroup> groups, double relative_error, double confidence = 0.95);

/// A prediction of the last budget from the budgets before it: the time to the error of the last one.
struct PredictionCheck {
    double predicted_seconds = 0, actual_seconds = 0;
    double octaves_ahead = 0;  ///< from the last budget that was used
    [[nodiscard]] double relative_difference() const { return predicted_seconds / actual_seconds - 1; }
};
/// Returns nothing with fewer than three budgets above the floor.
std::optional<PredictionCheck> check_prediction(std::span<const BudgetGroup> groups);

}  // namespace raylex::experiments
