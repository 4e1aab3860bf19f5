// The raylex program. Each subcommand has its own files in the folders beside this one.
#pragma once

namespace raylex::experiments {

/// Parses the command line, runs one subcommand and returns its exit code (program/exit_codes.h). Prints messages to
/// standard error and results to standard output.
int run_command_line(int argc, const char* const* argv);

}  // namespace raylex::experiments
