// A renderer outside this program, run by a shell: what it cost and how it ended.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>

#include "experiments/study/plan/shell_places.h"
#include "lpe/result.h"

namespace raylex::experiments {

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
