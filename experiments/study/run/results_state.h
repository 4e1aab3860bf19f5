// What a results directory is found to be, for all that go on with one.
#pragma once

#include <string>

#include "experiments/study/plan/config.h"
#include "experiments/study/results.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// An Error about a directory or file of the results.
Error directory_error(const std::string& path, std::string message, std::string hint = {});

/// Whether the results are of this config, overrides included; an Error at the config names both.
Status check_same_config(const Experiment& results, const ExperimentConfig& config);

}  // namespace raylex::experiments
