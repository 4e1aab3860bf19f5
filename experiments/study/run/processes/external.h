// Runs an external renderer by a shell; returns its costs and exit code.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>

#include "experiments/study/plan/shell_places.h"
#include "lpe/result.h"

namespace raylex::experiments {

struct ProcessOutcome {
    int exit_code = -1;  ///< 128 + signal if a signal ended it
    bool timed_out = false, stopped = false;
    double wall_seconds = 0;
    double cpu_seconds = 0;  ///< user and system, of the shell and its children
    std::uint64_t peak_memory_bytes = 0;
    std::string last_words;  ///< end of its standard error, or else of its standard output
};

/// Runs `command` by /bin/sh in `directory`, in its own process group, with its output in `log`. A timeout (0: none) or
/// `*stop` ends the whole group; `progress` receives the id of the group. Errors: no process could be started.
Result<ProcessOutcome> run_process(const ShellCommand& command, const std::string& directory, const std::string& log,
                                   double timeout_seconds, const std::atomic<bool>* stop,
                                   const std::function<void(double seconds, int group)>& progress);

}  // namespace raylex::experiments
