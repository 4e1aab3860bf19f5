// A renderer outside this program: a shell command with its places filled in, its cost and what it leaves.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "display/services/parameters.h"
#include "experiments/study/results.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// A line for a shell, and the environment that it gets beside this program's own.
struct ShellCommand {
    std::string text;
    NamedValues environment;
};

/// The command with {scene} and so on filled in; ${scene} is the shell's own. A value never becomes text that a shell
/// reads: one of nothing but letters, digits and _./:,+@%=- stands as it is, any other travels in the environment as
/// RAYLEX_SCENE and so on (all places do), and its place becomes that variable, quoted as the text around it asks.
/// Errors, at `where`: such a value in a command that hands text to another shell (eval, sh -c, ssh) or in a here
/// document.
Result<ShellCommand> fill_command(const std::string& command, const NamedValues& places, const SourceLocation& where);
/// Whether the command asks for it, as {spp} or by the variable that has it.
bool has_place(const std::string& command, const std::string& name);
/// RAYLEX_SCENE for "scene", RAYLEX_INTEGRATOR_STRATEGY for "integrator.strategy".
std::string place_variable(const std::string& name);

struct ProcessOutcome {
    int exit_code = -1;  ///< 128 + signal when one ended it
    bool timed_out = false, stopped = false;
    double wall_seconds = 0;
    double cpu_seconds = 0;  ///< user and system, of the shell and all it waited for
    std::uint64_t peak_memory_bytes = 0;
    std::string last_words;  ///< the end of what it wrote to standard error, or else to standard output
};

/// Runs `command` by /bin/sh in `directory`, in a process group of its own; its output goes to `log` there. A timeout
/// (0: none) or `*stop` ends the whole group, whose id `progress` gets. Errors: no process could be made.
Result<ProcessOutcome> run_process(const ShellCommand& command, const std::string& directory, const std::string& log,
                                   double timeout_seconds, const std::atomic<bool>* stop,
                                   const std::function<void(double seconds, int group)>& progress);

}  // namespace raylex::experiments
