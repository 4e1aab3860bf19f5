// What a results directory is found to be, for all that go on with one.
#pragma once

#include <string>

#include "experiments/study/plan/config.h"
#include "experiments/study/results.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// An Error about a directory or file of the results.
Error directory_error(const std::string& path, std::string message, std::string hint = {});

/// Whether the results are of this config, overrides included; an Error at the config names both.
Status check_same_config(const Experiment& results, const ExperimentConfig& config);

/// Held while a run writes to a directory of results, so that no second one renders the same cells into the same files.
/// The system lets go of it when the process ends, however it does.
class DirectoryLock {
  public:
    DirectoryLock() = default;
    ~DirectoryLock();
    DirectoryLock(const DirectoryLock&) = delete;
    DirectoryLock& operator=(const DirectoryLock&) = delete;
    /// Shards of one run may share a directory: each has a lock of its `name`. An Error when another process has it.
    Status take(const std::string& directory, const std::string& name);
    /// In a copy of this process: the lock is not its own, and does not outlive the process that has it.
    void leave_to_parent();

  private:
    int file_ = -1;
};

}  // namespace raylex::experiments
