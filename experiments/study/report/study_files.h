// A study as text for other programs, and as the data of its plots.
#pragma once

#include <string>
#include <vector>

#include "experiments/study/report/study.h"

namespace raylex::experiments {

/// One row per cell, channel and region with every metric; a header row with each metric's formula. RFC 4180.
std::string results_csv(const Study& study);

/// One JSON object per line, told apart by "kind": formulas, run, cell, budget, slope, time_to_error, prediction, bias,
/// first_words, setting, split, omission. Numbers that are not finite are null.
std::string results_jsonl(const Study& study);

/// A plot's specification for plot.js.
struct Plot {
    std::string id;    ///< unique in the study
    std::string file;  ///< name for plots/: "cornell.beauty.svg"
    std::string json;
};
/// Per scene, channel and region: error against time; per scene and channel the Pareto front of all budgets of all
/// variants.
std::vector<Plot> plots_of(const Study& study);

/// Key of a scene's channel and region, as plots and panels use it.
std::string plot_id(std::size_t scene, const std::string& channel, const std::string& region);
std::string front_id(std::size_t scene, const std::string& channel);

/// The points of a channel's Pareto front, by seconds.
struct FrontPoint {
    const Curve* curve = nullptr;
    const BudgetPoint* point = nullptr;
};
std::vector<FrontPoint> front_of(const Study& study, const std::string& scene, const std::string& channel);

/// "1.23 %", with few digits; "below 0" errors are those that noise subtraction left nothing of.
std::string percent_text(double share, int digits = 3);

}  // namespace raylex::experiments
