// Locks that show which process does a piece of work, such as a shard of a render or a reference.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "lpe/result.h"

namespace raylex::experiments {

/// Locks an open file; the lock ends with its last descriptor. Returns false if another process holds the lock. On file
/// systems without locks, returns true without a lock.
[[nodiscard]] bool lock_file(int descriptor);

/// A lock that a process holds during a piece of work, so that no other process does the same work. The system releases
/// it when the process ends for any reason. On file systems without locks, nothing is locked.
class WorkLock {
  public:
    /// Creates `file` and locks it; the file is removed with the lock. Returns an Error if another process holds the
    /// lock; `what` describes its work.
    static Result<WorkLock> take(const std::string& file, const std::string& what);
    /// Returns whether a process holds the lock of that file. It does not take the lock, so it never disturbs another
    /// process.
    static bool is_held(const std::string& file);

    WorkLock(WorkLock&& other) noexcept;
    WorkLock(const WorkLock&) = delete;
    WorkLock& operator=(const WorkLock&) = delete;
    ~WorkLock();

  private:
    WorkLock(std::string path, int file) : path_(std::move(path)), file_(file) {}
    std::string path_;
    int file_ = -1;
};

/// Waits for missing files as long as processes on this machine hold locks of some of them, and `seconds` longer. The
/// Error names a file that is still missing.
Status wait_for_files(const std::vector<std::string>& files,
                      const std::function<std::string(const std::string& file)>& lock_of, double seconds);

}  // namespace raylex::experiments
