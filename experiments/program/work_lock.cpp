#include "experiments/program/work_lock.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <thread>

#include "display/services/parameters.h"

namespace raylex::experiments {
namespace {

/// Describes a lock on a whole file. Such a lock belongs to the open file and ends with its last descriptor. Unlike
/// with flock(), it can be tested without being taken.
struct flock whole_file() {
    struct flock range {};
    range.l_type = F_WRLCK;
    range.l_whence = SEEK_SET;
    return range;
}

/// Returns whether `path` still names the open file. A process that releases the lock removes the file too.
bool is_still_there(int descriptor, const std::string& path) {
    struct stat open_file {
    }, named{};
    return fstat(descriptor, &open_file) == 0 && stat(path.c_str(), &named) == 0 && open_file.st_dev == named.st_dev &&
           open_file.st_ino == named.st_ino;
}

}  // namespace

bool lock_file(int descriptor) {
    struct flock range = whole_file();
    return fcntl(descriptor, F_OFD_SETLK, &range) == 0 || (errno != EAGAIN && errno != EACCES);
}

Result<WorkLock> WorkLock::take(const std::string& file, const std::string& what) {
    constexpr int most_tries = 100;  // bounds the loop on file systems whose file numbers are not stable
    for (int tries = 0;; ++tries) {
        const int descriptor = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
        if (descriptor < 0) return WorkLock(file, -1);
        if (!lock_file(descriptor)) {
            close(descriptor);
            return error_at({file, 0, 0}, "another process " + what,
                            "wait for it, or end it; finished work is not lost");
        }
        if (tries == most_tries || is_still_there(descriptor, file)) return WorkLock(file, descriptor);
        close(descriptor);  // removed between open and lock: another process may hold the new file
    }
}

bool WorkLock::is_held(const std::string& file) {
    const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor < 0) return false;
    struct flock range = whole_file();
    const bool held = fcntl(descriptor, F_OFD_GETLK, &range) == 0 && range.l_type != F_UNLCK;
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
                            "this file does not exist, and no process on this machine is making it (" +
                                std::to_string(missing.size()) + " of " + std::to_string(files.size()) +
                                " shards are missing)",
                            "run the missing shards; finished shards are not rendered again");
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
}

}  // namespace raylex::experiments
