// raylex render --shards N --commands: splits one render into commands for many machines.
#pragma once

#include "experiments/cli/render/render_options.h"
#include "experiments/job/job.h"

namespace raylex::experiments {

/// Prints one command per shard and one that merges the shards. Writes no file. Returns the exit code.
int print_render_commands(const CLI::App& command, const RenderOptions& options, Job job,
                          const std::vector<std::string>& arguments);

}  // namespace raylex::experiments
