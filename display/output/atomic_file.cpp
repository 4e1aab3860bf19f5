#include "display/output/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <utility>
#include <vector>

namespace raylex::display {

namespace {

constexpr std::size_t buffer_limit = std::size_t{1} << 20;

// A write past the file size limit (ulimit -f) kills the process unless SIGXFSZ is ignored; then it is an ordinary
// error. An existing handler is kept.
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

FileFault& file_fault() {
    static FileFault fault;
    return fault;
}

/// Returns whether a test makes this call fail; errno gives the reason.
bool fails(FileCall call, const std::string& path) {
    if (!file_fault()) return false;
    const int error_number = file_fault()(call, path);
    if (error_number != 0) errno = error_number;
    return error_number != 0;
}

/// Names of temporary files for a signal handler, which may use only lock-free atomics. Code that takes a name out of
/// its slot owns it; names that a handler takes are never freed.
std::array<std::atomic<char*>, 64> unfinished{};
static_assert(std::atomic<char*>::is_always_lock_free);

std::atomic<char*>* keep_unfinished(const std::string& path) {
    char* const name = strdup(path.c_str());
    for (std::atomic<char*>& place : unfinished) {
        char* none = nullptr;
        if (name != nullptr && place.compare_exchange_strong(none, name)) return &place;
    }
    std::free(name);  // more files than slots: an interrupt leaves this file
    return nullptr;
}

void sync_folder_of(const std::string& path) {
    if (fails(FileCall::sync_folder, path)) return;
    const int folder = open(folder_of(path).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder < 0) return;
    fsync(folder);  // best effort: the data itself is already safe
    close(folder);
}

Error kind_error(const std::string& path, mode_t mode) {
    const char* kind = S_ISDIR(mode) ? "a directory" : S_ISCHR(mode) || S_ISBLK(mode) ? "a device" : "a pipe or socket";
    Error error;
    error.file = path;
    error.message = std::string("cannot write the file: this is ") + kind + "; expected the name of a regular file";
    return error;
}

}  // namespace

Result<AtomicFile> AtomicFile::create(const std::string& path, FileSync sync) {
    ignore_file_size_signal();
    AtomicFile file;
    file.sync_ = sync;
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
        if (fails(FileCall::open, file.target_)) break;
        file.descriptor_ = open(file.temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (file.descriptor_ >= 0) {
            file.unfinished_ = keep_unfinished(file.temporary_);
            return file;
        }
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
        sync_ = other.sync_;
        unfinished_ = std::exchange(other.unfinished_, nullptr);
    }
    return *this;
}

AtomicFile::~AtomicFile() {
    discard();
}

void AtomicFile::forget() noexcept {
    if (unfinished_ != nullptr) std::free(unfinished_->exchange(nullptr));
    unfinished_ = nullptr;
}

void remove_unfinished() noexcept {
    for (std::atomic<char*>& place : unfinished)
        if (const char* const name = place.exchange(nullptr); name != nullptr) unlink(name);
}

void AtomicFile::discard() noexcept {
    forget();
    if (descriptor_ < 0) return;
    close(descriptor_);
    unlink(temporary_.c_str());
    descriptor_ = -1;
}

bool AtomicFile::flush() {
    const bool written = write_through(buffer_.data(), buffer_.size());
    buffer_.clear();
    return written;
}

bool AtomicFile::write_through(const char* bytes, std::size_t left) {
    while (left != 0 && error_number_ == 0) {
        const ssize_t written = fails(FileCall::write, target_) ? -1 : ::write(descriptor_, bytes, left);
        if (written >= 0) {
            bytes += written;
            left -= static_cast<std::size_t>(written);
        } else if (errno != EINTR) {
            error_number_ = errno;
        }
    }
    return error_number_ == 0;
}

bool AtomicFile::write(const void* bytes, std::size_t size) {
    if (error_number_ != 0 || descriptor_ < 0) return false;
    position_ += size;
    // Large writes skip the buffer.
    if (size >= buffer_limit) return flush() && write_through(static_cast<const char*>(bytes), size);
    buffer_.append(static_cast<const char*>(bytes), size);
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
    // Some file systems cannot sync (EINVAL); that must not lose the image.
    if (flush() && sync_ == FileSync::now && (fails(FileCall::sync, target_) || fsync(descriptor_) != 0) &&
        errno != EINVAL)
        error_number_ = errno;
    if (error_number_ == 0) {
        const bool fault = fails(FileCall::close, target_);
        const int fault_number = errno;
        if (close(std::exchange(descriptor_, -1)) != 0 || fault) {
            error_number_ = fault ? fault_number : errno;
            unlink(temporary_.c_str());
        }
    }
    if (error_number_ != 0) {
        discard();
        return failure();
    }
    forget();
    if (fails(FileCall::rename, target_) || rename(temporary_.c_str(), target_.c_str()) != 0) {
        error_number_ = errno;
        unlink(temporary_.c_str());
        return failure();
    }
    if (sync_ == FileSync::now) sync_folder_of(target_);
    return success();
}

Status sync_files_in(const std::string& folder) {
    std::error_code failed;
    std::vector<std::pair<std::string, int>> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder, failed)) {
        if (!entry.is_regular_file(failed)) continue;
        const int file = open(entry.path().c_str(), O_RDONLY | O_CLOEXEC);
        files.emplace_back(entry.path().string(), file);
        // Starts writing all files before waiting for the first, so that the file system commits them together. This is
        // only a hint; fsync gives the guarantee.
        if (file >= 0) sync_file_range(file, 0, 0, SYNC_FILE_RANGE_WRITE);
    }
    Status status = success();
    if (failed) status = write_error(folder, failed.value());
    for (const auto& [path, file] : files) {
        // EINVAL: as in commit().
        if (file < 0 || ((fails(FileCall::sync, path) || fsync(file) != 0) && errno != EINVAL))
            status = write_error(path, errno);
        if (file >= 0) close(file);
    }
    sync_folder_of(folder + "/.");
    return status;
}

Status remove_file(const std::string& path) {
    if ((fails(FileCall::remove, path) || unlink(path.c_str()) != 0) && errno != ENOENT) {
        Error error;
        error.file = path;
        error.message = "cannot remove the file: " + std::string(std::strerror(errno));
        return error;
    }
    sync_folder_of(path);
    return success();
}

void remove_abandoned(const std::string& path) {
    const std::string prefix = std::filesystem::path(path).filename().string() + ".";
    std::error_code failed;
    std::vector<std::filesystem::path> abandoned;
    for (const auto& entry : std::filesystem::directory_iterator(folder_of(path), failed)) {
        const std::string name = entry.path().filename().string();
        int process = 0, number = 0, end = 0;
        if (!name.starts_with(prefix)) continue;
        const char* rest = name.c_str() + prefix.size();
        if (std::sscanf(rest, "%d-%d.partial%n", &process, &number, &end) != 2 || end == 0 || rest[end] != '\0')
            continue;
        if (process > 0 && kill(process, 0) != 0 && errno == ESRCH) abandoned.push_back(entry.path());
    }
    for (const auto& each : abandoned) std::filesystem::remove(each, failed);
}

void set_file_fault(FileFault fault) {
    file_fault() = std::move(fault);
}

Status check_writable(const std::string& path) {
    Result<AtomicFile> file = AtomicFile::create(path);
    if (!file) return std::move(file).error();
    return success();
}

Status write_text_file(const std::string& path, const std::string& text, FileSync sync) {
    Result<AtomicFile> file = AtomicFile::create(path, sync);
    if (!file) return std::move(file).error();
    if (!file->write(text.data(), text.size())) return file->failure();
    return file->commit();
}

}  // namespace raylex::display
