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

/// A lock of the open file, which goes with its last descriptor: flock() with a way to look without taking.
struct flock whole_file() {
    struct flock range {};
    range.l_type = F_WRLCK;
    range.l_whence = SEEK_SET;
    return range;
}

/// Whether `path` still leads to the open file: whoever held the lock before removes the file with it.
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
    constexpr int most_tries = 100;  // where a file system numbers files anew, nobody would get the lock
    for (int tries = 0;; ++tries) {
        const int descriptor = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
        if (descriptor < 0) return WorkLock(file, -1);
        if (!lock_file(descriptor)) {
            close(descriptor);
            return error_at({file, 0, 0}, "another process " + what,
                            "wait for it; what it has done is not lost if it is ended");
        }
        if (tries == most_tries || is_still_there(descriptor, file)) return WorkLock(file, descriptor);
        close(descriptor);  // removed between open and lock: another process may hold the file that is there now
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
                            "this is not there, and no process of this machine is at it (" +
                                std::to_string(missing.size()) + " of " + std::to_string(files.size()) +
                                " shards are missing)",
                            "run the shards that are missing; those that are done are not rendered again");
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
}

}  // namespace raylex::experiments
