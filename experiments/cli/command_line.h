// The raylex program: one subcommand per file pair beside this one.
#pragma once

namespace raylex::experiments {

/// Exit codes of every subcommand.
inline constexpr int exit_holds = 0;          ///< done, and what was checked holds
inline constexpr int exit_does_not_hold = 1;  ///< a check failed
inline constexpr int exit_bad_input = 2;      ///< bad usage or input
inline constexpr int exit_interrupted = 130;  ///< Ctrl-C

/// Parses the command line, runs one subcommand and returns its exit code. Messages go to standard error, results to
/// standard output.
int run_command_line(int argc, const char* const* argv);

}  // namespace raylex::experiments
