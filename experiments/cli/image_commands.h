// Subcommands that handle images and colours. commands.h describes their arguments.
#pragma once

#include "experiments/cli/commands.h"

namespace raylex::experiments {

void add_denoise_command(CLI::App& app, CommandContext& context);
void add_preview_command(CLI::App& app, CommandContext& context);
void add_mix_command(CLI::App& app, CommandContext& context);
void add_ocio_command(CLI::App& app, CommandContext& context);

}  // namespace raylex::experiments
