// Checks scenes in a process of its own: a scene that kills or hangs the process becomes a verdict.
#pragma once

#include <atomic>
#include <string>

#include "experiments/invariants/invariants.h"
#include "experiments/study/run/processes/child_process.h"

namespace raylex::experiments {

/// Name of the verdict on a scene whose process ended without a report.
inline constexpr const char* death_result = "death";

/// A process that runs check_invariants(). After a death, the next check starts a new process.
class CheckingProcess {
  public:
    /// `path`: relative file names in scenes are relative to its folder. A check that takes longer than
    /// `timeout_seconds` ends with the process.
    CheckingProcess(std::string path, double timeout_seconds);
    /// The report of check_invariants(), or one verdict `death_result` whose note describes how the process ended.
    /// Errors: those of check_invariants(); no process could be made.
    Result<SceneReport> check(const std::string& text, const InvariantOptions& options, const std::atomic<bool>* stop);

  private:
    const double timeout_seconds_;
    ChildProcess process_;
};

/// Limits the memory of this process to 3 GiB, so that a huge scene is refused, and turns off core files.
void limit_checking_process();

}  // namespace raylex::experiments
