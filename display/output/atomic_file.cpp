#include "display/output/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <utility>

namespace raylex::display {

namespace {

constexpr std::size_t buffer_limit = std::size_t{1} << 20;

// A write past the file size limit (ulimit -f) kills the process unless SIGXFSZ is ignored; ignored, it is an ordinary
// error. A handler that somebody installed is left alone.
void ignore_file_size_signal() {
    static std::once_flag once;
    std::call_once(once, [] {
        struct sigaction current {};
        if (sigaction(SIGXFSZ, nullptr, &current) == 0 && current.sa_handler == SIG_DFL) {
            current.sa_handler = SIG_IGN;
            sigaction(SIGXFSZ, &current, nullptr);
        }
    });
}

std::string folder_of(const std::string& path) {
    const std::string folder = std::filesystem::path(path).parent_path().string();
    return folder.empty() ? "." : folder;
}

const char* expectation(int error_number) {
    switch (error_number) {
        case ENOSPC:
        case EDQUOT:
            return "free space on the disk";
        case EFBIG:
            return "a file size below the process's limit (ulimit -f)";
        case ENOENT:
        case ENOTDIR:
            return "a folder that exists";
        case EACCES:
        case EPERM:
        case EROFS:
            return "a folder that may be written to";
        default:
            return "a file that can be written";
    }
}

Error write_error(const std::string& path, int error_number) {
    Error error;
    error.file = path;
    error.message = "cannot write the file: " + std::string(std::strerror(error_number)) + "; expected " +
                    expectation(error_number);
    return error;
}

Error kind_error(const std::string& path, mode_t mode) {
    const char* kind = S_ISDIR(mode) ? "a directory" : S_ISCHR(mode) || S_ISBLK(mode) ? "a device" : "a pipe or socket";
    Error error;
    error.file = path;
    error.message = std::string("cannot write the file: this is ") + kind + "; expected the name of a regular file";
    return error;
}

}  // namespace

Result<AtomicFile> AtomicFile::create(const std::string& path) {
    ignore_file_size_signal();
    AtomicFile file;
    file.target_ = path;
    std::error_code ignored;
    if (std::filesystem::is_symlink(path, ignored)) {
        const std::string resolved = std::filesystem::weakly_canonical(path, ignored).string();
        if (!ignored) file.target_ = resolved;
    }
    struct stat status {};
    if (stat(file.target_.c_str(), &status) == 0 && !S_ISREG(status.st_mode)) return kind_error(path, status.st_mode);
    if (path.empty() || path.back() == '/') return write_error(path, EISDIR);

    static std::atomic<unsigned> counter{0};
    for (int attempt = 0; attempt < 100; ++attempt) {
        file.temporary_ = file.target_ + "." + std::to_string(getpid()) + "-" + std::to_string(counter++) + ".partial";
        file.descriptor_ = open(file.temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (file.descriptor_ >= 0) return file;
        if (errno != EEXIST) break;
    }
    return write_error(path, errno);
}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept {
    *this = std::move(other);
}

AtomicFile& AtomicFile::operator=(AtomicFile&& other) noexcept {
    if (this != &other) {
        discard();
        target_ = std::move(other.target_);
        temporary_ = std::move(other.temporary_);
        buffer_ = std::move(other.buffer_);
        position_ = other.position_;
        descriptor_ = std::exchange(other.descriptor_, -1);
        error_number_ = other.error_number_;
    }
    return *this;
}

AtomicFile::~AtomicFile() {
    discard();
}

void AtomicFile::discard() noexcept {
    if (descriptor_ < 0) return;
    close(descriptor_);
    unlink(temporary_.c_str());
    descriptor_ = -1;
}

bool AtomicFile::flush() {
    const char* bytes = buffer_.data();
    std::size_t left = buffer_.size();
    while (left != 0 && error_number_ == 0) {
        const ssize_t written = ::write(descriptor_, bytes, left);
        if (written >= 0) {
            bytes += written;
            left -= static_cast<std::size_t>(written);
        } else if (errno != EINTR) {
            error_number_ = errno;
        }
    }
    buffer_.clear();
    return error_number_ == 0;
}

bool AtomicFile::write(const void* bytes, std::size_t size) {
    if (error_number_ != 0 || descriptor_ < 0) return false;
    buffer_.append(static_cast<const char*>(bytes), size);
    position_ += size;
    return buffer_.size() < buffer_limit || flush();
}

bool AtomicFile::seek(std::uint64_t position) {
    if (position == position_) return error_number_ == 0;
    if (!flush()) return false;
    if (lseek(descriptor_, static_cast<off_t>(position), SEEK_SET) < 0) error_number_ = errno;
    position_ = position;
    return error_number_ == 0;
}

Error AtomicFile::failure() const {
    return write_error(target_, error_number_ == 0 ? EIO : error_number_);
}

Status AtomicFile::commit() {
    if (descriptor_ < 0) return write_error(target_, EBADF);
    // Some file systems cannot sync (EINVAL); that is no reason to lose the image.
    if (flush() && fsync(descriptor_) != 0 && errno != EINVAL) error_number_ = errno;
    if (error_number_ == 0 && close(std::exchange(descriptor_, -1)) != 0) {
        error_number_ = errno;
        unlink(temporary_.c_str());
    }
    if (error_number_ != 0) {
        discard();
        return failure();
    }
    if (rename(temporary_.c_str(), target_.c_str()) != 0) {
        error_number_ = errno;
        unlink(temporary_.c_str());
        return failure();
    }
    const int folder = open(folder_of(target_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder >= 0) {
        fsync(folder);  // best effort: the data itself is safe already
        close(folder);
    }
    return success();
}

Status check_writable(const std::string& path) {
    Result<AtomicFile> file = AtomicFile::create(path);
    if (!file) return std::move(file).error();
    return success();
}

Status write_text_file(const std::string& path, const std::string& text) {
    Result<AtomicFile> file = AtomicFile::create(path);
    if (!file) return std::move(file).error();
    if (!file->write(text.data(), text.size())) return file->failure();
    return file->commit();
}

}  // namespace raylex::display
