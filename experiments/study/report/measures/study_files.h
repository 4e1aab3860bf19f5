// A study as text for other programs, and as data of its plots.
#pragma once

#include <string>
#include <vector>

#include "experiments/study/report/measures/study.h"

namespace raylex::experiments {

/// Returns one row per cell, channel and region with every metric, after a header of names with letters, digits and _.
/// Format: RFC 4180.
std::string results_csv(const Study& study);
/// Returns a description of the columns of results_csv: column, unit, meaning or formula. Format: RFC 4180.
std::string columns_csv();

/// Returns one JSON object per line. "kind" distinguishes them: formulas, run, cell, budget, slope, time_to_error,
/// prediction, bias, first_words, setting, split, omission. Non-finite numbers are null.
std::string results_jsonl(const Study& study);

/// A plot's specification for plot.js.
struct Plot {
    std::string id;    ///< unique in the study
    std::string file;  ///< name for plots/: "cornell.beauty.svg"
    std::string json;
};
/// Returns the plots. Per scene, channel and region: error against time and, if known, against samples. Per scene and
/// channel: the Pareto front of all budgets of all variants, and the error spectra. Per scene with forced effects: the
/// cost of each effect.
std::vector<Plot> plots_of(const Study& study);

/// Returns a name for any file system; other characters become _.
std::string file_part(const std::string& name);
/// Returns the key of a scene's channel and region in plots and panels.
std::string plot_id(std::size_t scene, const std::string& channel, const std::string& region);
std::string samples_id(std::size_t scene, const std::string& channel, const std::string& region);
std::string front_id(std::size_t scene, const std::string& channel);
std::string spectrum_id(std::size_t scene, const std::string& channel);

/// A point of a channel's Pareto front.
struct FrontPoint {
    const Curve* curve = nullptr;
    const BudgetPoint* point = nullptr;
};
std::vector<FrontPoint> front_of(const Study& study, const std::string& scene, const std::string& channel);

/// Returns a number with `digits` significant digits, without an exponent between 1e-6 and 1e9: "3210", "0.00012",
/// "0.5".
std::string plain_number(double value, int digits = 3);
/// Returns a fraction as per cent: "1.23 %", "3210 %".
std::string percent_text(double share, int digits = 3);
/// Returns a budget in words: "128 samples", "1 sample", "30 s", "to 1 %".
std::string spoken_budget(BudgetKind kind, double budget);

}  // namespace raylex::experiments
