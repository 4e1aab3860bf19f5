// --commands: the work of a subcommand, printed for other machines instead of done.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "experiments/cli/commands.h"
#include "experiments/cluster/command_plan.h"

namespace raylex::experiments {

struct CommandOutputOptions {
    std::string format;  ///< empty: the work is done
    bool no_calibration = false;
};

/// --commands[=FORMAT] and --no-calibration, which `group` shows in --help; empty: with the others.
void add_command_output_options(CLI::App& command, CommandOutputOptions& options, const std::string& group);

/// The command line of the subcommand as one that stands alone: the program and all files by their whole paths, from
/// `arguments` as they were given. Options of `without` are left out, with their values.
std::vector<std::string> standing_alone(const CLI::App& command, const std::vector<std::string>& arguments,
                                        const std::set<std::string>& without);

std::string absolute_path(const std::string& path);
/// Prints the plan; the exit code.
int print_commands(const CommandPlan& plan, const std::string& format);

}  // namespace raylex::experiments
