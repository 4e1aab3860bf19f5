// Checks the state of a results directory before a run continues in it.
#pragma once

#include <optional>
#include <string>

#include "experiments/study/plan/config.h"
#include "experiments/study/results.h"
#include "experiments/study/run/cells/run_parts.h"
#include "experiments/study/run/runner.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// Returns an Error about a directory or file of the results.
Error directory_error(const std::string& path, std::string message, std::string hint = {});

/// Checks that the results belong to this config, overrides included. The Error at the config names both.
Status check_same_config(const Experiment& results, const ExperimentConfig& config);

/// Returns the results that the directory already has; nothing if it is new or empty. Errors: results of another config
/// or another --split-cells, finished cells without `resume`, incomplete cells, a directory with other files.
Result<std::optional<Experiment>> earlier_results(const ExperimentConfig& config, const RunRequest& request,
                                                  const WorkList& work);

/// Moves cells with changed files to damaged/ID, and adds them to `missing`, so that they are rendered again.
Status set_damaged_aside(Experiment& results);

/// A lock of a run on its results directory, so that no two runs render the same cells into the same files. The system
/// releases it when the process ends for any reason.
class DirectoryLock {
  public:
    DirectoryLock() = default;
    ~DirectoryLock();
    DirectoryLock(const DirectoryLock&) = delete;
    DirectoryLock& operator=(const DirectoryLock&) = delete;
    /// Takes the lock. Shards of one run may share a directory: each has its own lock, `name`. Error: another process
    /// has the lock.
    Status take(const std::string& directory, const std::string& name);
    /// Disowns the lock in a forked process: it belongs to the parent and ends with it.
    void leave_to_parent();

  private:
    int file_ = -1;
};

}  // namespace raylex::experiments
