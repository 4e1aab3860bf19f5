#include <algorithm>
#include <cmath>

#include "experiments/program/console.h"
#include "experiments/study/report/measures/study_files.h"
#include "experiments/study/report/paper/paper.h"

namespace raylex::experiments {
namespace {

/// Returns "1.23 [1.20, 1.26]", with a dagger if the interval is invalid, or a dash without a value.
std::string interval_text(const Interval& interval, double scale) {
    if (!std::isfinite(interval.value)) return "--";
    std::string text = plain_number(interval.value * scale);
    if (std::isfinite(interval.low) && std::isfinite(interval.high))
        text += " [" + plain_number(interval.low * scale) + ", " + plain_number(interval.high * scale) + "]";
    return interval.valid() ? text : text + "$^\\dagger$";
}

}  // namespace

std::string latex_text(const std::string& text) {
    std::string result;
    for (const char c : text) {
        switch (c) {
            case '\\':
                result += "\\textbackslash{}";
                break;
            case '~':
                result += "\\textasciitilde{}";
                break;
            case '^':
                result += "\\textasciicircum{}";
                break;
            case '<':
                result += "\\textless{}";
                break;
            case '>':
                result += "\\textgreater{}";
                break;
            case '&':
            case '%':
            case '$':
            case '#':
            case '_':
            case '{':
            case '}':
                result += '\\';
                [[fallthrough]];
            default:
                result += static_cast<unsigned char>(c) < 32 ? ' ' : c;
        }
    }
    return result;
}

std::string latex_table(const Study& study, const std::string& scene, const std::string& channel) {
    constexpr double target = 0.01;
    std::string rows;
    bool uncertain = false;
    for (const Curve& curve : study.curves) {
        if (curve.scene != scene || curve.channel != channel || !curve.region.empty() || curve.points.empty()) continue;
        const BudgetPoint& point = curve.points.back();
        std::string time = "--";
        for (const TimeToError& each : curve.times)
            if (each.relative_error == target && std::isfinite(each.seconds.value)) {
                time = plain_number(each.seconds.value) + (each.extrapolated ? "$^\\ast$" : "");
                if (!each.seconds.valid()) time += "$^\\dagger$";
            }
        rows += latex_text(curve.variant) + " & " + latex_text(spoken_budget(curve.budget_kind, point.budget)) + " & " +
                plain_number(point.seconds) + " & " + interval_text(point.relative, 100) + " & " + time + " & " +
                (curve.first ? "1" : interval_text(curve.speed_up, 1)) + " \\\\\n";
        uncertain = uncertain || !point.relative.valid() || !curve.speed_up.valid();
    }
    if (rows.empty()) return {};
    return "% " + latex_text(study.experiment->name + ": " + scene + ", " + channel) +
           ". Needs \\usepackage{booktabs}.\n"
           "% Relative error: 100 sqrt(relmse-mean)" +
           (study.noise_subtracted(scene, channel) ? ", the reference's noise subtracted" : "") +
           "; intervals: " + plain_number(study.options.confidence * 100) +
           " %.\n% Speed-up: 1 / (relmse-mean x seconds), relative to the first row. $^\\ast$ extrapolated.\n" +
           (uncertain ? "% $^\\dagger$ interval not valid: report.html has the reason.\n" : "") +
           (study.experiment->cpu_clock ? "% Times are CPU seconds of all threads.\n" : "") +
           "\\begin{tabular}{llrlrl}\n\\toprule\nMethod & Budget & Time [s] & Relative error [\\%] & Time to 1\\,\\% "
           "[s] & "
           "Speed-up \\\\\n\\midrule\n" +
           rows + "\\bottomrule\n\\end{tabular}\n";
}

}  // namespace raylex::experiments
