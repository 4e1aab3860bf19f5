// How an error falls: fitted slopes, the time to an error, and the prediction of later budgets from earlier ones.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "experiments/study/analysis/intervals.h"

namespace raylex::experiments {

/// All replicates of a variant at one budget. Errors are squared relative errors, the reference's noise subtracted.
struct BudgetGroup {
    double budget = 0;
    std::vector<double> errors;   ///< of each replicate
    std::vector<double> seconds;  ///< wall, everything counted
    std::vector<double> samples;  ///< per pixel; 0 where not known
    double setup_seconds = 0;     ///< mean of what does not grow with the budget: loading, building, pre-passes
    bool at_floor = false;        ///< the reference's noise is more than half of what was measured
    bool heavy_tail = false;
};

enum class Against { seconds, samples };

/// log e = intercept + slope log x by ordinary least squares over replicates, Student's t on the residuals, so both the
/// replicates' scatter and any lack of fit widen the interval.
struct Line {
    double intercept = 0, slope = 0;
    double slope_low = 0, slope_high = 0;
    double residual = 0;         ///< standard deviation of one replicate about the line, log units
    double mean_x = 0, sxx = 0;  ///< of log x
    double count = 0, degrees = 0;
    double least_x = 0, most_x = 0;
};

inline constexpr double slope_octaves = 4;

/// The line through the budgets within `octaves` of the largest that is not at the reference's floor. Nothing when
/// fewer than two budgets or fewer than three replicates with positive errors are left, or x is not known.
std::optional<Line> fit_line(std::span<const BudgetGroup> groups, Against against, double octaves = slope_octaves,
                             double confidence = 0.95);

struct SlopeVerdict {
    std::optional<Line> seconds, samples;
    bool too_shallow = false;  ///< declared unbiased, and shallower than -1 at the last octaves, where it stays
    bool nears = false;        ///< shallower than -1, and on its way there, as of a start-up
    std::string text;          ///< a phrase for the table: "-1 is in the interval", "too shallow: ..."
    /// The line that is judged: against samples where they are known, since the load of a machine is no evidence.
    [[nodiscard]] const std::optional<Line>& judged() const { return samples ? samples : seconds; }
};
/// A method that starts up (chains that warm up, guides that learn) falls slower at first, and its slope comes nearer
/// to -1 with every octave; the slope of a biased one does the opposite. A method is too shallow when its slope over
/// the last four octaves and that over the last two lie above -0.98 and the latter is farther from -1 than half of what
/// the slope before was, all at 95 %, and no nearer than it by a standard error. That takes four budgets over more than
/// two octaves, with three replicates each.
SlopeVerdict judge_slope(std::span<const BudgetGroup> groups, bool declared_unbiased);

/// The seconds at which the relative error (root of the squared one) is `relative_error`.
struct TimeToError {
    double relative_error = 0;
    Interval seconds;           ///< NaN and a note when it is never reached
    bool extrapolated = false;  ///< outside the measured times
};

/// Inside the measured budgets from a line through those within an octave of the target's bracket; outside, from the
/// last (or first) four octaves with the slope fixed at -1 unless the fitted 99 % interval excludes it. x is samples
/// per pixel, where they are known, priced at the nearest large budget; else the time less the setup. The setup is
/// added again. Intervals by the delta method; times beyond 2^10 of the measured ones, and those whose interval is
/// wider than widest_ratio, are not given.
TimeToError time_to_error(std::span<const BudgetGroup> groups, double relative_error, double confidence = 0.95);

/// What the budgets before the last say about the last: the time to the error that the last one had.
struct PredictionCheck {
    double predicted_seconds = 0, actual_seconds = 0;
    double octaves_ahead = 0;  ///< from the last budget that was used
    [[nodiscard]] double relative_difference() const { return predicted_seconds / actual_seconds - 1; }
};
/// Nothing with fewer than three budgets above the floor.
std::optional<PredictionCheck> check_prediction(std::span<const BudgetGroup> groups);

}  // namespace raylex::experiments
