#include "experiments/shards/shard_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <thread>

#include "display/services/parameters.h"

namespace raylex::experiments {
namespace {

std::string lock_file(const std::string& record) {
    return record + ".lock";
}

}  // namespace

Result<ShardLock> ShardLock::take(const std::string& record) {
    ShardLock lock(lock_file(record), -1);
    const int file = open(lock.path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (file < 0) return lock;
    if (flock(file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
        close(file);
        return error_at({record, 0, 0}, "another process is rendering this shard",
                        "wait for it; what it has rendered is not lost if it is ended");
    }
    lock.file_ = file;
    return lock;
}

bool ShardLock::is_held(const std::string& record) {
    const int file = open(lock_file(record).c_str(), O_RDONLY | O_CLOEXEC);
    if (file < 0) return false;
    const bool held = flock(file, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    close(file);
    return held;
}

ShardLock::ShardLock(ShardLock&& other) noexcept
    : path_(std::move(other.path_)), file_(std::exchange(other.file_, -1)) {}

ShardLock::~ShardLock() {
    if (file_ < 0) return;
    unlink(path_.c_str());
    close(file_);
}

Status wait_for_records(const std::vector<std::string>& records, double seconds) {
    using Clock = std::chrono::steady_clock;
    std::error_code failed;
    for (Clock::time_point last = Clock::now();;) {
        std::vector<std::string> missing;
        for (const std::string& each : records)
            if (!std::filesystem::exists(each, failed)) missing.push_back(each);
        if (missing.empty()) return success();
        if (std::any_of(missing.begin(), missing.end(), ShardLock::is_held)) last = Clock::now();
        if (std::chrono::duration<double>(Clock::now() - last).count() > seconds)
            return error_at({missing.front(), 0, 0},
                            "this record is not there, and no process here renders it (" +
                                std::to_string(missing.size()) + " of " + std::to_string(records.size()) +
                                " are missing)",
                            "run the shards that are missing; those that are done are not rendered again");
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
}

}  // namespace raylex::experiments
