// The flags of raylex render, in the groups of its --help.
#pragma once

#include <string>
#include <vector>

#include "experiments/cli/command_output.h"
#include "experiments/job/job.h"

namespace raylex::experiments {

struct RenderOptions {
    std::string input;
    std::vector<std::string> plugins;
    CommandOutputOptions commands;
};

/// Adds a flag for every setting.
void add_render_options(CLI::App& command, RenderOptions& options);
/// Sets the job's settings from the flags on the command line, in the order of the table.
Status apply_flags(const CLI::App& command, Job& job);

}  // namespace raylex::experiments
