// The exit codes of the program, its subcommands and the processes that it starts.
#pragma once

namespace raylex::experiments {

inline constexpr int exit_holds = 0;          ///< success, and all checks hold
inline constexpr int exit_does_not_hold = 1;  ///< a check failed
inline constexpr int exit_bad_input = 2;      ///< bad usage or input
inline constexpr int exit_interrupted = 130;  ///< Ctrl-C

}  // namespace raylex::experiments
