// Private to config.cpp: the tables of an experiment's config beside scenes and methods.
#pragma once

#include <string>
#include <vector>

#include "experiments/job/text/toml_table.h"
#include "experiments/study/plan/config.h"

namespace raylex::experiments {

/// Names that stand in file names: letters, digits, _ and -.
void check_short_name(TomlTable& table, std::string_view key, const std::string& name);
/// timeout = "10m".
void read_timeout(TomlTable& table, double& seconds);
void require_file(TomlTable& table, std::string_view key, const std::string& path, const char* what);

void read_budgets(TomlTable& root, std::vector<Budget>& budgets);
void read_reference(TomlTable& root, ExperimentConfig& config);
void read_regions(TomlTable& root, ExperimentConfig& config);
/// After scenes, methods and budgets.
void read_exclusions(TomlTable& root, ExperimentConfig& config);
/// What only the whole config can tell: names of scenes and methods, commands that cannot do what is asked.
Status check_config(ExperimentConfig& config);

}  // namespace raylex::experiments
