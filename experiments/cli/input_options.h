// Options of every command that reads files: --budget, and the check that file names are not empty.
#pragma once

#include <CLI/App.hpp>

#include "lpe/result.h"

namespace raylex::experiments {

/// Applies the budgets of the environment variable RAYLEX_BUDGETS, "NAME=VALUE,...". From now on, interrupts stop
/// reading.
Status prepare_reading();

/// Adds --budget to all commands below `app`, and makes options that take file names refuse empty names.
void add_input_options(CLI::App& app);

}  // namespace raylex::experiments
