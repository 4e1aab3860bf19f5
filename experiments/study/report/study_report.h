// The report of an experiment: report.html, results.csv, results.columns.csv, results.jsonl, plots/*.svg, tables/*.tex
// and insets/*.png.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "experiments/study/results.h"

namespace raylex::experiments {

struct StudyReportOptions {
    std::string directory;                   ///< folder for the files; empty: the experiment's directory
    std::size_t picture_bytes = 45'000'000;  ///< limit for all pictures on the page, which are reduced to fit
    double confidence = 0.95;                ///< confidence of intervals
    double bias_level = 0.01;                ///< level of all bias tests of a variant on a scene together
};

struct Study;
/// Returns the bias verdict of every variant on every scene where something was tested: "path on room: no bias found;
/// ...".
std::vector<std::string> result_lines(const Study& study);

/// Measures every cell against its scene's reference and writes the files atomically. Prints the names of the files,
/// and warnings about everything that could not be judged. Returns an exit code: 0 written; 2 bad input, a file that
/// cannot be written (with a message), or damaged files that were left out. Verdicts are results, so they do not change
/// the exit code.
int write_study_report(const Experiment& experiment, const StudyReportOptions& options = {});

}  // namespace raylex::experiments
