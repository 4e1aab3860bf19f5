#include "experiments/program/work_lock.h"

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

Result<WorkLock> WorkLock::take(const std::string& file, const std::string& what) {
    WorkLock lock(file, -1);
    const int descriptor = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (descriptor < 0) return lock;
    if (flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
        close(descriptor);
        return error_at({file, 0, 0}, "another process " + what,
                        "wait for it; what it has done is not lost if it is ended");
    }
    lock.file_ = descriptor;
    return lock;
}

bool WorkLock::is_held(const std::string& file) {
    const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor < 0) return false;
    const bool held = flock(descriptor, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    close(descriptor);
    return held;
}

WorkLock::WorkLock(WorkLock&& other) noexcept : path_(std::move(other.path_)), file_(std::exchange(other.file_, -1)) {}

WorkLock::~WorkLock() {
    if (file_ < 0) return;
    unlink(path_.c_str());
    close(file_);
}

Status wait_for_files(const std::vector<std::string>& files,
                      const std::function<std::string(const std::string& file)>& lock_of, double seconds) {
    using Clock = std::chrono::steady_clock;
    std::error_code failed;
    for (Clock::time_point last = Clock::now();;) {
        std::vector<std::string> missing;
        for (const std::string& each : files)
            if (!std::filesystem::exists(each, failed)) missing.push_back(each);
        if (missing.empty()) return success();
        if (std::any_of(missing.begin(), missing.end(),
                        [&](const std::string& each) { return WorkLock::is_held(lock_of(each)); }))
            last = Clock::now();
        if (std::chrono::duration<double>(Clock::now() - last).count() > seconds)
            return error_at({missing.front(), 0, 0},
                            "this is not there, and no process of this machine is at it (" +
                                std::to_string(missing.size()) + " of " + std::to_string(files.size()) +
                                " shards are missing)",
                            "run the shards that are missing; those that are done are not rendered again");
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
}

}  // namespace raylex::experiments
