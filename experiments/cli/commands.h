// The subcommands. Each function registers its options and a callback that sets the exit code.
#pragma once

#include <string>
#include <vector>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "lpe/result.h"

namespace raylex::experiments {

/// Input and output of every subcommand: the words of the command line, and the exit code.
struct CommandContext {
    std::vector<std::string> arguments;
    int exit_code = 0;
};

void add_render_command(CLI::App& app, CommandContext& context);
void add_passes_command(CLI::App& app, CommandContext& context);
void add_lpe_command(CLI::App& app, CommandContext& context);
void add_verify_command(CLI::App& app, CommandContext& context);
void add_ask_command(CLI::App& app, CommandContext& context);
void add_compare_command(CLI::App& app, CommandContext& context);
void add_stability_command(CLI::App& app, CommandContext& context);
void add_plugins_command(CLI::App& app, CommandContext& context);
void add_new_command(CLI::App& app, CommandContext& context);
void add_report_command(CLI::App& app, CommandContext& context);
void add_merge_command(CLI::App& app, CommandContext& context);
void add_submit_command(CLI::App& app, CommandContext& context);
void add_status_command(CLI::App& app, CommandContext& context);
void add_experiment_command(CLI::App& app, CommandContext& context);
void add_scene_command(CLI::App& app, CommandContext& context);
void add_help_command(CLI::App& app, CommandContext& context);

/// Writes into `folder`, which has the layout of /usr/share: a man page for each command, and completions for bash, zsh
/// and fish. Texts are those of --help.
Status write_manual(const CLI::App& app, const std::string& folder);

}  // namespace raylex::experiments
