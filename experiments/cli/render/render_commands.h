// raylex render --shards N --commands: one render as commands for many machines.
#pragma once

#include "experiments/cli/render/render_options.h"
#include "experiments/job/job.h"

namespace raylex::experiments {

/// Prints a command for each shard and one that merges them; nothing is written. The exit code.
int print_render_commands(const CLI::App& command, const RenderOptions& options, Job job,
                          const std::vector<std::string>& arguments);

}  // namespace raylex::experiments
