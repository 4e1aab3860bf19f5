// The last step of a cell: syncs its files to disk and renames its directory. Waiting for a disk needs no processor, so
// it happens during the next render, one cell at a time.
#pragma once

#include <condition_variable>
#include <ctime>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "experiments/study/results.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// A directory with all files written except cell.json, which lists them. It gets its final name only after they are on
/// disk, so a name in cells/ always means a complete cell.
struct WrittenRun {
    StudyRun run;  ///< for cell.json; `files` is filled in
    std::string partial, final_name;
    std::vector<std::string> obsolete;  ///< files to remove afterwards: a checkpoint, an earlier failure
};

/// Writes cell.json, syncs and renames immediately.
Status close_run_directory(const WrittenRun& run);

class RunCloser {
  public:
    RunCloser();
    /// Waits for the cell in progress.
    ~RunCloser();
    RunCloser(const RunCloser&) = delete;
    RunCloser& operator=(const RunCloser&) = delete;

    /// Starts to close a cell after waiting for the previous one. If the previous one failed, returns its failure, and
    /// this cell stays .partial.
    Status close(WrittenRun run);
    /// Waits for the last cell and returns its failure, once.
    Status wait();
    /// Total CPU time of this work, to be subtracted from the process's CPU time for the render.
    [[nodiscard]] double cpu_seconds() const;

  private:
    void work();
    std::mutex mutex_;
    std::condition_variable changed_;
    std::optional<WrittenRun> cell_;  // in progress
    Status status_ = success();
    bool ending_ = false;
    clockid_t clock_ = CLOCK_THREAD_CPUTIME_ID;
    std::thread thread_;
};

}  // namespace raylex::experiments
