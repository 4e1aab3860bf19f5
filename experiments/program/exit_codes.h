// What the program's exit codes mean, for its subcommands and for the processes that it starts.
#pragma once

namespace raylex::experiments {

inline constexpr int exit_holds = 0;          ///< done, and what was checked holds
inline constexpr int exit_does_not_hold = 1;  ///< a check failed
inline constexpr int exit_bad_input = 2;      ///< bad usage or input
inline constexpr int exit_interrupted = 130;  ///< Ctrl-C

}  // namespace raylex::experiments
