// A file that appears whole or not at all (Law 7): written under a temporary name beside its target, synced, renamed.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

#include "lpe/result.h"

namespace raylex::display {

/// Whether a file is safe on disk when the call returns, or only after sync_files_in(): many at once cost little more
/// than one.
enum class FileSync : std::uint8_t { now, later };

/// The temporary file is `target` + ".<process>-<number>.partial". Until commit() succeeds an earlier file at the
/// target is untouched; destroying an uncommitted AtomicFile removes the temporary one.
///
/// A symbolic link is followed: what it points at is replaced, the link stays. A target that exists and is not a
/// regular file (a directory, a device) is refused.
class AtomicFile {
  public:
    static Result<AtomicFile> create(const std::string& path, FileSync sync = FileSync::now);
    AtomicFile(AtomicFile&& other) noexcept;
    AtomicFile& operator=(AtomicFile&& other) noexcept;
    ~AtomicFile();

    /// Appends at the current position. After a failure (disk full, quota) every later call fails with the same error.
    [[nodiscard]] bool write(const void* bytes, std::size_t size);
    [[nodiscard]] bool seek(std::uint64_t position);
    [[nodiscard]] std::uint64_t position() const { return position_; }

    /// Syncs the file, renames it to the target and syncs the folder; renames it only, when it is to be synced later.
    Status commit();
    /// The first failure so far, as an Error that names the target; what commit() would return after it.
    [[nodiscard]] Error failure() const;
    [[nodiscard]] bool failed() const { return error_number_ != 0; }
    [[nodiscard]] const std::string& target() const { return target_; }

  private:
    AtomicFile() = default;
    void discard() noexcept;
    void forget() noexcept;
    bool flush();
    bool write_through(const char* bytes, std::size_t left);

    std::string target_, temporary_;
    std::string buffer_;  // bytes not yet handed to the system, standing at position_ - buffer_.size()
    std::uint64_t position_ = 0;
    int descriptor_ = -1;
    int error_number_ = 0;
    FileSync sync_ = FileSync::now;
    std::atomic<char*>* unfinished_ = nullptr;  // where remove_unfinished() finds the temporary file's name
};

/// Removes the temporary files that are being written, whose writing then fails. A signal's handler may call it that
/// ends the process.
void remove_unfinished() noexcept;

/// Makes every file in the folder safe on disk, then the folder itself; not what is in folders of it.
Status sync_files_in(const std::string& folder);

/// Removes a file and syncs its folder; a file that is not there is no error.
Status remove_file(const std::string& path);

/// Removes the temporary files of `path` that processes of this machine left behind when they were killed. Call it only
/// where no other machine writes the same file.
void remove_abandoned(const std::string& path);

/// Whether a file could be made at `path` now: makes a temporary one and removes it. Ask before a long render.
Status check_writable(const std::string& path);

/// Text in one go.
Status write_text_file(const std::string& path, const std::string& text, FileSync sync = FileSync::now);

/// The system calls that make or remove a file.
enum class FileCall { open, write, sync, close, rename, sync_folder, remove };

/// A seam for tests of recovery: asked before each such call, on the file that it is about; a number that is not 0 is
/// the errno with which the call fails instead of being made. Set it, and reset it with nullptr, while no file is being
/// written.
using FileFault = std::function<int(FileCall call, const std::string& path)>;
void set_file_fault(FileFault fault);

}  // namespace raylex::display
