// A renderer outside this program: a shell command with its places filled in, its cost and what it leaves.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "experiments/study/results.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// {scene} and so on, each value quoted for a shell; ${scene} is the shell's own.
std::string fill_command(const std::string& command, const NamedValues& places);

struct ProcessOutcome {
    int exit_code = -1;  ///< 128 + signal when one ended it
    bool timed_out = false, stopped = false;
    double wall_seconds = 0;
    double cpu_seconds = 0;  ///< user and system, of the shell and all it waited for
    std::uint64_t peak_memory_bytes = 0;
    std::string last_words;  ///< the end of what it wrote to standard error, or else to standard output
};

/// Runs `command` by /bin/sh in `directory`, in a process group of its own; its output goes to `log` there. A timeout
/// (0: none) or `*stop` ends the whole group. Errors: no process could be made.
Result<ProcessOutcome> run_process(const std::string& command, const std::string& directory, const std::string& log,
                                   double timeout_seconds, const std::atomic<bool>* stop,
                                   const std::function<void(double seconds)>& progress);

}  // namespace raylex::experiments
