// The JSON side of the results contract (results.h): what the runner and merge write.
#pragma once

#include <string>

#include "experiments/study/results.h"

namespace raylex::experiments {

inline constexpr const char* experiment_format = "raylex-experiment 1";

/// cell.json, and failed/ID.json for one that failed.
Status write_cell_file(const std::string& path, const Cell& cell, display::FileSync sync = display::FileSync::now);
Result<Cell> read_cell_file(const std::string& path);

/// What these files hold; `where` is named when the text is something else.
std::string cell_text(const Cell& cell);
Result<Cell> cell_of_text(const std::string& text, const std::string& where);

/// config.toml, then experiment.json, which says by being there that the directory is whole. Of the experiment's cells
/// only `planned` is written: what became of them is in their own files.
Status write_experiment_files(const Experiment& experiment);

/// Where things are in a results directory.
std::string experiment_file(const std::string& directory);
std::string cell_directory(const std::string& directory, const std::string& id);
std::string partial_directory(const std::string& directory, const std::string& id);
std::string failed_file(const std::string& directory, const std::string& id);
/// The cell's ID of a part called ID.pKofN; empty when the name is none of a part.
std::string cell_of_part(const std::string& name);

}  // namespace raylex::experiments
