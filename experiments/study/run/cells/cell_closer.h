// The last step of a cell: its files made safe on disk, its directory renamed. Waiting for a disk costs no processor,
// so it is done beside the next render, one cell at a time.
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

/// A directory whose files are all written but cell.json, which lists them. It gets its final name only once they are
/// on disk: a name in cells/ is a whole cell, whatever happens.
struct WrittenCell {
    Cell cell;  ///< for cell.json; `files` is filled in
    std::string partial, final_name;
    std::vector<std::string> obsolete;  ///< files that go when the rest is safe: a checkpoint, an earlier failure
};

/// Writes cell.json, syncs and renames at once.
Status close_cell_directory(const WrittenCell& cell);

class CellCloser {
  public:
    CellCloser();
    /// Waits for what is under way.
    ~CellCloser();
    CellCloser(const CellCloser&) = delete;
    CellCloser& operator=(const CellCloser&) = delete;

    /// Waits for the cell before, whose failure it returns: then this one is not begun, and stays .partial.
    Status close(WrittenCell cell);
    /// Of the last cell. A failure is told once.
    Status wait();
    /// CPU time of all this so far: what a clock of the whole process must not call the render's.
    [[nodiscard]] double cpu_seconds() const;

  private:
    void work();
    std::mutex mutex_;
    std::condition_variable changed_;
    std::optional<WrittenCell> cell_;  // under way
    Status status_ = success();
    bool ending_ = false;
    clockid_t clock_ = CLOCK_THREAD_CPUTIME_ID;
    std::thread thread_;
};

}  // namespace raylex::experiments
