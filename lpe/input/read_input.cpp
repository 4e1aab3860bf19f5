#include "lpe/input/read_input.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace raylex {

namespace {

std::atomic<const std::atomic<bool>*> stop_flag{nullptr};

class Descriptor {
  public:
    explicit Descriptor(int number) : number_(number) {}
    ~Descriptor() {
        if (number_ >= 0) ::close(number_);
    }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    [[nodiscard]] int number() const { return number_; }

  private:
    int number_;
};

Error failure(const std::string& path, const std::string& message) {
    return {message, path, 0, 0, {}, {}};
}

Error system_failure(const std::string& path, const std::string& expected) {
    return failure(path, std::string("cannot read this file: ") + std::strerror(errno) + "; expected " + expected);
}

const char* kind_of(mode_t mode) {
    return S_ISDIR(mode)    ? "a directory"
           : S_ISFIFO(mode) ? "a pipe"
           : S_ISSOCK(mode) ? "a socket"
           : S_ISCHR(mode)  ? "a device"
           : S_ISBLK(mode)  ? "a device"
                            : "not a regular file";
}

Status check_kind(const std::string& path, mode_t mode, NamedBy by, const std::string& expected) {
    if (S_ISREG(mode)) return success();
    const bool stream = S_ISFIFO(mode) || S_ISCHR(mode);
    if (stream && by == NamedBy::command_line) return success();
    return failure(path, std::string("this is ") + kind_of(mode) + "; expected " + expected +
                             (stream ? ", in a regular file" : ""));
}

Status check_name(const std::string& path, const std::string& expected) {
    if (path.empty()) return failure(path, "the file's name is empty; expected " + expected);
    if (path.find('\0') != std::string::npos) return failure(path, "the file's name contains a zero byte");
    return success();
}

/// Waits until there is something to read; returns false when reading must stop. A pipe may never get any data.
bool wait_readable(int descriptor) {
    constexpr int milliseconds = 100;
    while (!reading_stopped()) {
        pollfd one{descriptor, POLLIN, 0};
        const int ready = ::poll(&one, 1, milliseconds);
        if (ready > 0) return true;
        if (ready < 0 && errno != EINTR && errno != EAGAIN) return true;  // read() will report the error
    }
    return false;
}

/// `stoppable`: whether stop_reading_when() applies.
Result<std::string> read_all(int descriptor, const std::string& path, std::size_t expected_size, Budget most,
                             const std::string& expected, bool stoppable) {
    const std::uint64_t bound = budget(most);
    constexpr std::size_t block = 1 << 20;
    std::string content;
    content.resize(std::max<std::size_t>(expected_size, 4'096) + 1);  // one extra byte, so that the end is found
                                                                      // without growing
    std::size_t used = 0;
    while (true) {
        if (used == content.size()) content.resize(2 * content.size());
        if (stoppable && !wait_readable(descriptor)) return reading_stopped_error(path);
        const ssize_t got = ::read(descriptor, content.data() + used, std::min(block, content.size() - used));
        if (got < 0) {
            if (errno == EINTR || errno == EAGAIN) continue;
            return system_failure(path, expected);
        }
        if (got == 0) break;
        used += static_cast<std::size_t>(got);
        if (used > bound) return over_budget(most, "the file is too large", path);
    }
    content.resize(used);
    return content;
}

}  // namespace

void stop_reading_when(const std::atomic<bool>* flag) {
    stop_flag = flag;
}

bool reading_stopped() {
    const std::atomic<bool>* flag = stop_flag;
    return flag != nullptr && flag->load(std::memory_order_relaxed);
}

Error reading_stopped_error(const std::string& path) {
    return failure(path, "interrupted while it was read");
}

void drop_byte_order_mark(std::string& text) {
    if (text.starts_with("\xef\xbb\xbf")) text.erase(0, 3);
}

namespace {

Result<std::string> read_file(const std::string& path, NamedBy by, const std::string& expected, Budget most,
                              bool stoppable) {
    if (Status name = check_name(path, expected); !name) return name.error();
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0) return system_failure(path, expected);
    if (Status kind = check_kind(path, status.st_mode, by, expected); !kind) return kind.error();
    // Without O_NONBLOCK, opening a pipe waits for a writer.
    const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
    if (file.number() < 0 || ::fstat(file.number(), &status) != 0) return system_failure(path, expected);
    if (Status kind = check_kind(path, status.st_mode, by, expected); !kind) return kind.error();
    const bool regular = S_ISREG(status.st_mode);
    const auto size = regular ? static_cast<std::uint64_t>(status.st_size) : 0;
    if (size > budget(most)) return over_budget(most, "the file has " + std::to_string(size) + " bytes", path);
    auto content = read_all(file.number(), path, size, regular ? most : Budget::pipe_bytes, expected, stoppable);
    if (content) drop_byte_order_mark(*content);
    return content;
}

}  // namespace

Result<std::string> read_input(const std::string& path, NamedBy by, const std::string& expected, Budget most) {
    return read_file(path, by, expected, most, true);
}

Result<std::string> read_record(const std::string& path, const std::string& expected, Budget most) {
    return read_file(path, NamedBy::file, expected, most, false);
}

Status check_regular_file(const std::string& path, const std::string& expected) {
    if (Status name = check_name(path, expected); !name) return name;
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0) return system_failure(path, expected);
    if (Status kind = check_kind(path, status.st_mode, NamedBy::file, expected); !kind) return kind;
    if (::access(path.c_str(), R_OK) != 0) return system_failure(path, expected);
    return success();
}

}  // namespace raylex
