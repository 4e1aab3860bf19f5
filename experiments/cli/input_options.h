// What every command has that reads something: --budget, and file names that are not empty.
#pragma once

#include <CLI/App.hpp>

#include "lpe/result.h"

namespace raylex::experiments {

/// Budgets of the environment variable RAYLEX_BUDGETS, "NAME=VALUE,...", hold from the start; reading hears interrupts.
Status prepare_reading();

/// Adds --budget to all commands below `app`, and refuses empty names of files where a command takes them by an option.
void add_input_options(CLI::App& app);

}  // namespace raylex::experiments
