// The report of an experiment: report.html, results.csv, results.columns.csv, results.jsonl, plots/*.svg, tables/*.tex
// and insets/*.png in its directory.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "experiments/study/results.h"

namespace raylex::experiments {

struct StudyReportOptions {
    std::string directory;                   ///< where the files go; empty: the experiment's own directory
    std::size_t picture_bytes = 45'000'000;  ///< of all pictures in the page; they are reduced until they fit
    double confidence = 0.95;                ///< of intervals
    double bias_level = 0.01;                ///< of all bias tests of a variant on a scene together
};

struct Study;
/// The verdict on bias of every variant on every scene, "path on room: no bias found; ...", where something was tested.
std::vector<std::string> verdict_lines(const Study& study);

/// Measures every cell against its scene's reference and writes the files, each whole or not at all. Prints what it
/// wrote, and warnings for what could not be judged. Returns an exit code: 0 written, 2 bad input or a file that cannot
/// be written (the message is printed), or damaged files were left out. Verdicts do not change the code: they are
/// results.
int write_study_report(const Experiment& experiment, const StudyReportOptions& options = {});

}  // namespace raylex::experiments
