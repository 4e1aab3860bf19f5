// Subcommands of `raylex scene`. commands.h describes their arguments.
#pragma once

#include "experiments/cli/commands.h"

namespace raylex::experiments {

void add_scene_info_command(CLI::App& scene, CommandContext& context);

}  // namespace raylex::experiments
