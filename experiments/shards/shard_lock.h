// Who renders a shard just now.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "lpe/result.h"

namespace raylex::experiments {

/// Held while a process renders a shard, so that no second one does. The system lets go of it when the process ends,
/// however it does; where a file system knows no locks, nobody has any.
class ShardLock {
  public:
    /// RECORD.lock, which is removed with the lock. An Error when another process has it.
    static Result<ShardLock> take(const std::string& record);
    /// Whether a process has the lock of that record.
    static bool is_held(const std::string& record);

    ShardLock(ShardLock&& other) noexcept;
    ShardLock(const ShardLock&) = delete;
    ShardLock& operator=(const ShardLock&) = delete;
    ~ShardLock();

  private:
    ShardLock(std::string path, int file) : path_(std::move(path)), file_(file) {}
    std::string path_;
    int file_ = -1;
};

/// Waits for the records that are not there yet, as long as processes on this machine render them, or `seconds` more
/// where none does. An Error names those that are still missing then.
Status wait_for_records(const std::vector<std::string>& records, double seconds);

}  // namespace raylex::experiments
