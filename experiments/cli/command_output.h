// --commands: prints the work of a subcommand as commands for other machines, instead of doing it.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "experiments/cli/commands.h"
#include "experiments/cluster/command_plan.h"

namespace raylex::experiments {

struct CommandOutputOptions {
    std::string format;  ///< empty: the subcommand does the work itself
    bool no_calibration = false;
};

/// Adds --commands[=FORMAT] and --no-calibration. `group` is their group in --help; empty: the default group.
void add_command_output_options(CLI::App& command, CommandOutputOptions& options, const std::string& group);

/// Returns the command line of the subcommand with absolute paths for the program and all files, so that it works in
/// any folder. `arguments` is the original command line. Omits the options in `without` and their values.
std::vector<std::string> standing_alone(const CLI::App& command, const std::vector<std::string>& arguments,
                                        const std::set<std::string>& without);

std::string absolute_path(const std::string& path);
/// Prints the plan and returns the exit code.
int print_commands(const CommandPlan& plan, const std::string& format);

}  // namespace raylex::experiments
