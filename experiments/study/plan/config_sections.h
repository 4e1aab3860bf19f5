// Private to config.cpp: reads the tables of an experiment's config except scenes and methods.
#pragma once

#include <string>
#include <vector>

#include "experiments/job/text/toml_table.h"
#include "experiments/study/plan/config.h"

namespace raylex::experiments {

/// Checks a name that becomes part of file names: letters, digits, _ and -.
void check_short_name(TomlTable& table, std::string_view key, const std::string& name);
/// Reads timeout = "10m".
void read_timeout(TomlTable& table, double& seconds);
void require_file(TomlTable& table, std::string_view key, const std::string& path, const char* what);

void read_budgets(TomlTable& root, std::vector<Budget>& budgets);
void read_reference(TomlTable& root, ExperimentConfig& config);
void read_regions(TomlTable& root, ExperimentConfig& config);
/// Reads [[exclude]]. Call it after scenes, methods and budgets.
void read_exclusions(TomlTable& root, ExperimentConfig& config);
/// Checks that need the whole config: names of scenes and methods, and commands that cannot support the plan.
Status check_config(ExperimentConfig& config);

}  // namespace raylex::experiments
