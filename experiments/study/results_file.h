// The JSON files of the results (results.h), written by the runner and by merge.
#pragma once

#include <string>

#include "experiments/study/results.h"

namespace raylex::experiments {

inline constexpr const char* experiment_format = "raylex-experiment 1";

/// Writes cell.json, or failed/ID.json for a failed cell.
Status write_cell_file(const std::string& path, const Cell& cell, display::FileSync sync = display::FileSync::now);
Result<Cell> read_cell_file(const std::string& path);

/// Parses the text of such a file. Errors name `where`.
std::string cell_text(const Cell& cell);
Result<Cell> cell_of_text(const std::string& text, const std::string& where);

/// Writes config.toml, then experiment.json, whose presence means that the directory is complete. Of the experiment's
/// cells only `planned` is written; results are in the cells' own files.
Status write_experiment_files(const Experiment& experiment);

/// Return the paths of files in a results directory.
std::string experiment_file(const std::string& directory);
std::string cell_directory(const std::string& directory, const std::string& id);
std::string partial_directory(const std::string& directory, const std::string& id);
std::string failed_file(const std::string& directory, const std::string& id);
/// Returns the cell's ID of a part named ID.pKofN; empty for other names.
std::string cell_of_part(const std::string& name);

}  // namespace raylex::experiments
