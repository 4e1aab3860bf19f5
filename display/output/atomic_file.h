// A file that appears completely or not at all (Law 7): written under a temporary name beside its target, synced,
// renamed.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

#include "lpe/result.h"

namespace raylex::display {

/// now: the file is safe on disk when the call returns. later: only after sync_files_in(), which syncs many files for
/// little more than the cost of one.
enum class FileSync : std::uint8_t { now, later };

/// The temporary file is `target` + ".<process>-<number>.partial". An earlier file at the target is unchanged until
/// commit() succeeds; destroying an uncommitted AtomicFile removes the temporary file.
///
/// Symbolic links are followed: the linked file is replaced, the link stays. A target that exists and is not a regular
/// file (a directory, a device) is refused.
class AtomicFile {
  public:
    static Result<AtomicFile> create(const std::string& path, FileSync sync = FileSync::now);
    AtomicFile(AtomicFile&& other) noexcept;
    AtomicFile& operator=(AtomicFile&& other) noexcept;
    ~AtomicFile();

    /// Writes at the current position. After a failure (disk full, quota) every later call fails with the same error.
    [[nodiscard]] bool write(const void* bytes, std::size_t size);
    [[nodiscard]] bool seek(std::uint64_t position);
    [[nodiscard]] std::uint64_t position() const { return position_; }

    /// Syncs the file, renames it to the target and syncs the folder. With FileSync::later it only renames it.
    Status commit();
    /// The first failure so far, as an Error that names the target. commit() returns it, too.
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
    std::string buffer_;  // bytes not yet passed to the system; their position is position_ - buffer_.size()
    std::uint64_t position_ = 0;
    int descriptor_ = -1;
    int error_number_ = 0;
    FileSync sync_ = FileSync::now;
    std::atomic<char*>* unfinished_ = nullptr;  // the slot in which remove_unfinished() finds the name of the temporary
                                                // file
};

/// Removes the temporary files that are being written; writing them then fails. A signal handler that ends the process
/// can call it.
void remove_unfinished() noexcept;

/// Makes every file in the folder safe on disk, then the folder itself; does not enter subfolders.
Status sync_files_in(const std::string& folder);

/// Removes a file and syncs its folder; a missing file is not an error.
Status remove_file(const std::string& path);

/// Removes the temporary files of `path` that killed processes of this machine left behind. Call it only if no other
/// machine writes the same file.
void remove_abandoned(const std::string& path);

/// Checks that a file can be created at `path`: creates a temporary one and removes it. Call it before a long render.
Status check_writable(const std::string& path);

/// Writes a whole text file.
Status write_text_file(const std::string& path, const std::string& text, FileSync sync = FileSync::now);

/// The system calls that make or remove a file.
enum class FileCall { open, write, sync, close, rename, sync_folder, remove };

/// For tests of recovery: called before each such call, with the file that it affects. A nonzero result is the errno
/// with which the call fails without being made. Set it, and reset it with nullptr, while no file is being written.
using FileFault = std::function<int(FileCall call, const std::string& path)>;
void set_file_fault(FileFault fault);

}  // namespace raylex::display
