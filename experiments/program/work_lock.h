// Who does a piece of work just now: a shard of a render, a reference.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "lpe/result.h"

namespace raylex::experiments {

/// Takes the lock of an open file, which ends with its last descriptor; false when somebody else has it. True, without
/// a lock, where the file system knows none.
[[nodiscard]] bool lock_file(int descriptor);

/// Held while a process does a piece of work, so that no second one does the same. The system lets go of it when the
/// process ends, however it does; where a file system knows no locks, nobody has any.
class WorkLock {
  public:
    /// `file` is made, and removed with the lock. An Error when another process has it; `what` it is doing then.
    static Result<WorkLock> take(const std::string& file, const std::string& what);
    /// Whether a process has the lock on that file; takes nothing, so that nobody who begins then is turned away.
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

/// Waits for files that are not there yet, as long as processes of this machine hold the locks of some, and `seconds`
/// more. An Error names what is still missing then.
Status wait_for_files(const std::vector<std::string>& files,
                      const std::function<std::string(const std::string& file)>& lock_of, double seconds);

}  // namespace raylex::experiments
