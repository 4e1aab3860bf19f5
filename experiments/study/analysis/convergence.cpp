#include "experiments/study/analysis/convergence.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "experiments/study/analysis/distributions.h"

namespace raylex::experiments {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// The reference's noise is subtracted only in expectation; the remainder can change the slope at large budgets by this
// much.
constexpr double slope_margin = 0.02;
constexpr std::size_t fewest_tested_budgets = 3;  // two points lie on a line for any error curve
constexpr double late_octaves = 2;
constexpr std::size_t fewest_replicates = 3;  // per budget: their scatter is the only known noise
constexpr double farthest_octaves = 10;       // a longer extrapolation would be a guess

struct Point {
    double x = 0, y = 0;  // logarithms
};

double mean_of(const std::vector<double>& values) {
    double sum = 0;
    for (const double value : values) sum += value;
    return values.empty() ? nan : sum / static_cast<double>(values.size());
}

/// Returns x of one replicate: samples, or the seconds that grow with the budget.
double abscissa(const BudgetGroup& group, std::size_t replicate, Against against) {
    if (against == Against::samples) return replicate < group.samples.size() ? group.samples[replicate] : 0;
    return group.seconds[replicate] - group.setup_seconds;
}

double mean_abscissa(const BudgetGroup& group, Against against) {
    return against == Against::samples ? mean_of(group.samples) : mean_of(group.seconds) - group.setup_seconds;
}

/// Returns a point for each replicate with an error above 0. The mean of logarithms is below the logarithm of the mean
/// by half the variance, so the points are shifted up to the mean error.
std::vector<Point> points_of(const BudgetGroup& group, Against against) {
    std::vector<Point> points;
    double sum = 0, sum_of_logs = 0;
    for (std::size_t i = 0; i < group.errors.size(); ++i) {
        const double x = abscissa(group, i, against), y = group.errors[i];
        if (!(x > 0 && y > 0 && std::isfinite(y))) continue;
        points.push_back({std::log(x), std::log(y)});
        sum += y;
        sum_of_logs += points.back().y;
    }
    const auto count = static_cast<double>(points.size());
    for (Point& point : points) point.y += std::log(sum / count) - sum_of_logs / count;
    return points;
}

std::optional<Line> least_squares(const std::vector<const BudgetGroup*>& groups, Against against, double confidence,
                                  std::optional<double> fixed_slope = std::nullopt) {
    std::vector<Point> points;
    for (const BudgetGroup* group : groups) {
        const std::vector<Point> more = points_of(*group, against);
        points.insert(points.end(), more.begin(), more.end());
    }
    if (points.size() < 2) return std::nullopt;
    Line line;
    line.count = static_cast<double>(points.size());
    line.least_x = std::numeric_limits<double>::infinity();
    line.most_x = -line.least_x;
    double mean_y = 0;
    for (const Point& point : points) {
        line.mean_x += point.x / line.count;
        mean_y += point.y / line.count;
        line.least_x = std::min(line.least_x, point.x);
        line.most_x = std::max(line.most_x, point.x);
    }
    double sxy = 0;
    for (const Point& point : points) {
        line.sxx += (point.x - line.mean_x) * (point.x - line.mean_x);
        sxy += (point.x - line.mean_x) * (point.y - mean_y);
    }
    line.degrees = line.count - (fixed_slope ? 1 : 2);
    // Budgets that span less than a tenth of an octave do not determine a slope.
    if (!fixed_slope && (line.most_x - line.least_x < 0.1 * std::log(2.0) || line.degrees < 1)) return std::nullopt;
    line.slope = fixed_slope ? *fixed_slope : sxy / line.sxx;
    line.intercept = mean_y - line.slope * line.mean_x;
    double squares = 0;
    for (const Point& point : points) {
        const double residual = point.y - line.intercept - line.slope * point.x;
        squares += residual * residual;
    }
    line.residual = std::sqrt(squares / line.degrees);
    line.slope_low = line.slope_high = line.slope;
    if (!fixed_slope) {
        const double half =
            student_t_quantile(1 - (1 - confidence) / 2, line.degrees) * line.residual / std::sqrt(line.sxx);
        line.slope_low = line.slope - half;
        line.slope_high = line.slope + half;
    }
    return line;
}

/// Returns the groups ordered by x, without budgets at the floor or without errors.
std::vector<const BudgetGroup*> usable_groups(std::span<const BudgetGroup> groups, Against against) {
    std::vector<const BudgetGroup*> usable;
    for (const BudgetGroup& group : groups)
        if (!group.at_floor && !group.errors.empty() && mean_abscissa(group, against) > 0) usable.push_back(&group);
    std::sort(usable.begin(), usable.end(), [against](const BudgetGroup* a, const BudgetGroup* b) {
        return mean_abscissa(*a, against) < mean_abscissa(*b, against);
    });
    return usable;
}

/// Returns the groups within `octaves` of the last one. Measured times scatter, so the limit has a margin of 5 %.
std::vector<const BudgetGroup*> last_octaves(const std::vector<const BudgetGroup*>& groups, Against against,
                                             double octaves) {
    std::vector<const BudgetGroup*> last;
    if (groups.empty()) return last;
    const double most = mean_abscissa(*groups.back(), against);
    for (const BudgetGroup* group : groups)
        if (mean_abscissa(*group, against) * std::exp2(octaves) * 1.05 >= most) last.push_back(group);
    return last;
}

std::vector<const BudgetGroup*> first_octaves(const std::vector<const BudgetGroup*>& groups, Against against,
                                              double octaves) {
    std::vector<const BudgetGroup*> first;
    for (const BudgetGroup* group : groups)
        if (mean_abscissa(*group, against) <= mean_abscissa(*groups.front(), against) * std::exp2(octaves) * 1.05)
            first.push_back(group);
    return first;
}

/// Returns the fitted line, with slope -1 unless the data exclude it at 99 %. The level is strict because every false
/// departure from -1 makes the interval of the time too narrow.
std::optional<Line> plain_line(const std::vector<const BudgetGroup*>& groups, Against against, double confidence) {
    const std::optional<Line> strict = least_squares(groups, against, 0.99);
    if (strict && (strict->slope_low > -1 || strict->slope_high < -1))
        return least_squares(groups, against, confidence);
    return least_squares(groups, against, confidence, -1.0);
}

/// The logarithm of the seconds per sample of every pixel beyond the setup, at one budget.
struct Cost {
    double log_value = 0, standard_error = 0;
};

Cost cost_of_sample(const BudgetGroup& group) {
    std::vector<double> logs;
    for (std::size_t i = 0; i < group.seconds.size(); ++i) {
        const double seconds = group.seconds[i] - group.setup_seconds;
        if (seconds > 0) logs.push_back(std::log(seconds / group.samples[i]));
    }
    Cost cost{mean_of(logs), 0};
    double squares = 0;
    for (const double each : logs) squares += (each - cost.log_value) * (each - cost.log_value);
    const auto count = static_cast<double>(logs.size());
    if (count > 1) cost.standard_error = std::sqrt(squares / (count - 1) / count);
    return cost;
}

/// Returns the index of the first of two neighbours whose mean errors enclose the target.
std::optional<std::size_t> bracket(const std::vector<const BudgetGroup*>& groups, double squared) {
    for (std::size_t i = 0; i + 1 < groups.size(); ++i) {
        const double before = mean_of(groups[i]->errors), after = mean_of(groups[i + 1]->errors);
        if (before >= squared && squared >= after) return i;
    }
    return std::nullopt;
}

}  // namespace

std::optional<Line> fit_line(std::span<const BudgetGroup> groups, Against against, double octaves, double confidence) {
    const std::vector<const BudgetGroup*> used = last_octaves(usable_groups(groups, against), against, octaves);
    if (used.size() < 2) return std::nullopt;
    return least_squares(used, against, confidence);
}

namespace {

/// The slopes over the last two octaves (at least three budgets), and over all budgets before; the two share one
/// budget.
struct Trend {
    Line early, late;
    bool persists = false, nears = false;  ///< the late slope stays above -1; approaches -1
};

/// Returns nothing if there are too few budgets or replicates to distinguish a start-up from a bias.
std::optional<Trend> trend_of(const std::vector<const BudgetGroup*>& groups, Against against) {
    const std::size_t late = std::max(fewest_tested_budgets, last_octaves(groups, against, late_octaves).size());
    if (groups.size() <= late) return std::nullopt;
    const auto shared = groups.end() - static_cast<std::ptrdiff_t>(late);
    const std::optional<Line> before = least_squares({groups.begin(), shared + 1}, against, 0.95),
                              after = least_squares({shared, groups.end()}, against, 0.95);
    if (!before || !after) return std::nullopt;
    // Both slopes are linear in the logarithms of the errors; so the difference of their distances from -1 is too. The
    // noise is that of the replicates.
    double squares = 0, degrees = 0, late_late = 0, late_early = 0, early_early = 0;
    for (auto group = groups.begin(); group != groups.end(); ++group) {
        const std::vector<Point> points = points_of(**group, against);
        if (points.size() < fewest_replicates) return std::nullopt;
        double mean = 0;
        for (const Point& point : points) mean += point.y / static_cast<double>(points.size());
        for (const Point& point : points) {
            const double in_late = group >= shared ? (point.x - after->mean_x) / after->sxx : 0,
                         in_early = group <= shared ? (point.x - before->mean_x) / before->sxx : 0;
            late_late += in_late * in_late;
            late_early += in_late * in_early;
            early_early += in_early * in_early;
            squares += (point.y - mean) * (point.y - mean);
        }
        degrees += static_cast<double>(points.size() - 1);
    }
    // In standard errors: the late distance minus a fraction of the early one.
    const auto excess = [&](double share) {
        const double variance = late_late - 2 * share * late_early + share * share * early_early;
        return (after->slope + 1 - share * (before->slope + 1)) / std::sqrt(variance * squares / degrees);
    };
    const double share = before->slope > -1 ? 0.5 : 0;  // a slope below -1 is not a start-up
    const bool nears = excess(1) < -1;
    return Trend{*before, *after, !nears && excess(share) > student_t_quantile(0.975, degrees), nears};
}

std::string slope_text(double slope) {
    const std::string text = std::to_string(std::round(slope * 100) / 100);
    return text.substr(0, text.find('.') + 3);
}

}  // namespace

SlopeTest test_slope(std::span<const BudgetGroup> groups, bool declared_unbiased) {
    SlopeTest verdict;
    verdict.seconds = fit_line(groups, Against::seconds);
    verdict.samples = fit_line(groups, Against::samples);
    const Against against = verdict.samples ? Against::samples : Against::seconds;
    const std::optional<Line>& line = verdict.checked();
    if (!line) {
        verdict.text = "unknown: needs two budgets and three replicates in total";
        return verdict;
    }
    const std::vector<const BudgetGroup*> usable = usable_groups(groups, against);
    if (last_octaves(usable, against, slope_octaves).size() < fewest_tested_budgets) {
        verdict.text = "not judged: two budgets determine only the slope between them; three are needed";
        return verdict;
    }
    const bool shallow = line->slope_low > -1 + slope_margin;
    const std::optional<Trend> trend = shallow ? trend_of(usable, against) : std::nullopt;
    const std::string change =
        trend ? ": from " + slope_text(trend->early.slope) + " to " + slope_text(trend->late.slope) : "";
    const bool heavy = std::any_of(groups.begin(), groups.end(), [](const BudgetGroup& g) { return g.heavy_tail; });
    if (!shallow) verdict.text = line->slope_high < -1 ? "steeper than -1" : "-1 is in the interval";
    else if (!declared_unbiased) verdict.text = "shallower than -1; declared biased";
    else if (!trend)
        verdict.text =
            "shallower than -1; not judged: needs four budgets over more than two octaves, with three replicates each, "
            "to distinguish a start-up from a bias";
    else if (trend->persists && trend->late.slope_low > -1 + slope_margin) {
        verdict.too_shallow = !heavy;
        verdict.text = "too shallow for a method declared unbiased" + change;
    } else {
        verdict.nears = !heavy && trend->nears;
        verdict.text = (trend->nears ? "not at -1 yet, but closer with every octave"
                        : trend->late.slope_low > -1 + slope_margin
                            ? "shallower than -1; not certain for further octaves"
                            : "shallower than -1 over the last 4 octaves, not certain for the last 2") +
                       change;
    }
    if (heavy) verdict.text += std::string("; ") + heavy_tail_note;
    return verdict;
}

namespace {

/// The line for the look-up of a squared error, and the budget with the cost per sample.
struct LocalLine {
    std::optional<Line> line;
    const BudgetGroup* timed;
    bool extrapolated;
};

/// Returns the line through the budgets around the error if there are budgets on both sides, otherwise through the
/// nearest octaves.
LocalLine line_at(const std::vector<const BudgetGroup*>& usable, double squared, Against against, double confidence) {
    if (const std::optional<std::size_t> at = bracket(usable, squared)) {
        const std::size_t first = *at > 0 ? *at - 1 : 0, last = std::min(usable.size() - 1, *at + 2);
        const std::vector<const BudgetGroup*> near(usable.begin() + static_cast<std::ptrdiff_t>(first),
                                                   usable.begin() + static_cast<std::ptrdiff_t>(last) + 1);
        std::optional<Line> line = least_squares(near, against, confidence);
        if (!line) line = plain_line(near, against, confidence);
        return {line, usable[*at + 1], false};
    }
    const bool early = squared > mean_of(usable.front()->errors);
    return {
        plain_line(early ? first_octaves(usable, against, slope_octaves) : last_octaves(usable, against, slope_octaves),
                   against, confidence),
        usable.back(), true};
}

}  // namespace

TimeToError time_to_error(std::span<const BudgetGroup> groups, double relative_error, double confidence) {
    TimeToError result;
    result.relative_error = relative_error;
    result.seconds = {nan, nan, nan, {}, {}};
    const double squared = relative_error * relative_error;
    // Times of short renders depend on start-up and machine load. Errors are therefore fitted over samples, and the
    // cost per sample is that of the nearest large budget.
    const bool sampled = std::all_of(groups.begin(), groups.end(), [](const BudgetGroup& group) {
        return group.samples.size() == group.errors.size() && mean_of(group.samples) > 0;
    });
    const Against against = sampled ? Against::samples : Against::seconds;
    const std::vector<const BudgetGroup*> usable = usable_groups(groups, against);
    if (usable.empty()) {
        result.seconds.note = "no errors above the reference's own";
        return result;
    }
    const auto [line, timed, extrapolated] = line_at(usable, squared, against, confidence);
    result.extrapolated = extrapolated;
    if (!line) {
        result.seconds.note = "no positive errors";
        return result;
    }
    if (!(line->slope < 0) || (result.extrapolated && line->slope_high >= 0 && line->slope_low < line->slope_high)) {
        result.seconds.note = "not reached: the error no longer falls";
        return result;
    }
    const double log_x = (std::log(squared) - line->intercept) / line->slope;
    const bool fixed = line->slope_low == line->slope_high;
    const double distance = log_x - line->mean_x;
    if (log_x > line->most_x + farthest_octaves * std::log(2.0)) {
        result.seconds.note = "more than 1000 times the measured times";
        return result;
    }
    const double setup = timed->setup_seconds;
    const Cost cost = sampled ? cost_of_sample(*timed) : Cost{};
    if (!std::isfinite(cost.log_value)) {
        result.seconds.note = "no time beyond the setup was measured";
        return result;
    }
    const double log_seconds = log_x + cost.log_value;
    result.seconds.value = std::exp(log_seconds) + setup;
    if (!(line->degrees >= 1)) {
        result.seconds.note = "one replicate";
        return result;
    }
    const double error = line->residual / std::abs(line->slope) *
                         std::sqrt(1 / line->count + (fixed ? 0 : distance * distance / line->sxx));
    const double half =
        student_t_quantile(1 - (1 - confidence) / 2, line->degrees) * std::hypot(error, cost.standard_error);
    result.seconds.low = std::exp(log_seconds - half) + setup;
    result.seconds.high = std::exp(log_seconds + half) + setup;
    if (result.seconds.high > widest_ratio * result.seconds.low) {
        result.seconds = {nan, nan, nan, wide_note, {}};
        return result;
    }
    result.seconds.how = fixed ? "slope -1" : "fitted slope";
    for (const BudgetGroup* group : usable)
        if (group->heavy_tail) result.seconds.note = heavy_tail_note;
    return result;
}

std::optional<PredictionCheck> check_prediction(std::span<const BudgetGroup> groups) {
    const std::vector<const BudgetGroup*> usable = usable_groups(groups, Against::seconds);
    if (usable.size() < 3) return std::nullopt;
    std::vector<BudgetGroup> early;
    for (std::size_t i = 0; i + 1 < usable.size(); ++i) early.push_back(*usable[i]);
    const double last_error = mean_of(usable.back()->errors);
    if (!(last_error > 0)) return std::nullopt;
    const TimeToError predicted = time_to_error(early, std::sqrt(last_error));
    if (!std::isfinite(predicted.seconds.value)) return std::nullopt;
    PredictionCheck check;
    check.predicted_seconds = predicted.seconds.value;
    check.actual_seconds = mean_of(usable.back()->seconds);
    check.octaves_ahead = std::log2(check.actual_seconds / mean_of(early.back().seconds));
    return check;
}

}  // namespace raylex::experiments
