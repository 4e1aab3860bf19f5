// A study as text for other programs, and as the data of its plots.
#pragma once

#include <string>
#include <vector>

#include "experiments/study/report/measures/study.h"

namespace raylex::experiments {

/// One row per cell, channel and region with every metric, below a header of plain names: letters, digits and _. RFC
/// 4180.
std::string results_csv(const Study& study);
/// What the columns of results_csv mean: column, unit, meaning or formula. RFC 4180.
std::string columns_csv();

/// One JSON object per line, told apart by "kind": formulas, run, cell, budget, slope, time_to_error, prediction, bias,
/// first_words, setting, split, omission. Numbers that are not finite are null.
std::string results_jsonl(const Study& study);

/// A plot's specification for plot.js.
struct Plot {
    std::string id;    ///< unique in the study
    std::string file;  ///< name for plots/: "cornell.beauty.svg"
    std::string json;
};
/// Per scene, channel and region: error against time and, where they are known, against samples; per scene and channel
/// the Pareto front of all budgets of all variants and the error spectra; per scene what each effect costs, where
/// effects are forced.
std::vector<Plot> plots_of(const Study& study);

/// Letters that any file system takes: others become _.
std::string file_part(const std::string& name);
/// Key of a scene's channel and region, as plots and panels use it.
std::string plot_id(std::size_t scene, const std::string& channel, const std::string& region);
std::string samples_id(std::size_t scene, const std::string& channel, const std::string& region);
std::string front_id(std::size_t scene, const std::string& channel);
std::string spectrum_id(std::size_t scene, const std::string& channel);

/// The points of a channel's Pareto front, by seconds.
struct FrontPoint {
    const Curve* curve = nullptr;
    const BudgetPoint* point = nullptr;
};
std::vector<FrontPoint> front_of(const Study& study, const std::string& scene, const std::string& channel);

/// To so many significant digits, without an exponent between 1e-6 and 1e9: "3210", "0.00012", "0.5".
std::string plain_number(double value, int digits = 3);
/// "1.23 %", "3210 %".
std::string percent_text(double share, int digits = 3);
/// "128 samples", "1 sample", "30 s", "to 1 %".
std::string spoken_budget(BudgetKind kind, double budget);

}  // namespace raylex::experiments
