// The JSON files of the results (results.h), written by the runner and by merge.
#pragma once

#include <string>

#include "experiments/study/results.h"

namespace raylex::experiments {

inline constexpr const char* experiment_format = "raylex-experiment 1";

/// Writes cell.json, or failed/ID.json for a failed cell.
Status write_run_file(const std::string& path, const StudyRun& run, display::FileSync sync = display::FileSync::now);
Result<StudyRun> read_run_file(const std::string& path);

/// Parses the text of such a file. Errors name `where`.
std::string run_text(const StudyRun& run);
Result<StudyRun> run_of_text(const std::string& text, const std::string& where);

/// Writes config.toml, then experiment.json, whose presence means that the directory is complete. Of the experiment's
/// cells only `planned` is written; results are in the cells' own files.
Status write_experiment_files(const Experiment& experiment);

/// Return the paths of files in a results directory.
std::string experiment_file(const std::string& directory);
std::string run_directory(const std::string& directory, const std::string& id);
std::string partial_directory(const std::string& directory, const std::string& id);
std::string failed_file(const std::string& directory, const std::string& id);
/// Returns the cell's ID of a part named ID.pKofN; empty for other names.
std::string run_of_part(const std::string& name);

}  // namespace raylex::experiments
