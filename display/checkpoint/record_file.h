// The file format of records: named sections, each with a checksum, and an identity that describes the content.
// Checkpoints use it; shards and experiment cells can, too.
//
// Version 1. Numbers have the byte order of the mark (little-endian on every machine that raylex supports):
//
//   8 bytes   89 "RLX" 0d 0a 1a 0a      as in PNG: detects transfers that change line ends
//   u32       01020304                  byte-order mark
//   u32       1                         version of this layout
//   u64       number of sections
//   u64       XXH64 of the 24 bytes before
//   then for each section, the first of which is "identity":
//     u64 size of the name, u64 size of the content, u64 XXH64 of the content, u64 XXH64 of these 24 bytes and the name
//     the name, then the content
//   u64       XXH64 of all the sections' content hashes, and nothing after it
//
// So a checksum covers every bit of the file, and a missing end is detected.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "display/output/atomic_file.h"
#include "lpe/result.h"

namespace raylex::display {

/// The description of a record, line by line: {"seed", "3"}, {"resolution", "640x480"}. The order only affects
/// messages.
using RecordIdentity = std::vector<std::pair<std::string, std::string>>;

struct RecordSection {
    std::string name;  ///< unique within the record
    std::string content;
};

struct RecordFile {
    RecordIdentity identity;
    std::vector<RecordSection> sections;

    /// Finds a section; null if there is none of that name.
    [[nodiscard]] const RecordSection* find(std::string_view name) const;
    /// Appends an empty section and returns its content.
    std::string& add(std::string name);
};

/// Writes the record completely or not at all: a temporary file, synced, renamed, then the folder synced. An earlier
/// file at `path` survives every failure.
Status write_record_file(const std::string& path, const RecordFile& record, FileSync sync = FileSync::now);

/// Reads and checks the whole file. Errors name the file and the problem: not a record file, a different version or
/// byte order, truncated (with the byte), or damaged (with the section).
Result<RecordFile> read_record_file(const std::string& path);

/// Writes a record file section by section, so that only one section must be in memory.
class RecordFileWriter {
  public:
    /// `sections` is the number of later calls of add().
    static Result<RecordFileWriter> create(const std::string& path, const RecordIdentity& identity,
                                           std::size_t sections, FileSync sync = FileSync::now);
    Status add(const std::string& name, std::string_view content);
    Status commit();

  private:
    explicit RecordFileWriter(AtomicFile file) : file_(std::move(file)) {}
    AtomicFile file_;
    std::string hashes_;
};

/// Reads and checks the sections of a record file one by one. No file stays open.
class RecordFileReader {
  public:
    /// Reads and checks everything except the contents; detects a file that is too short for them.
    static Result<RecordFileReader> open(const std::string& path);

    [[nodiscard]] const std::string& path() const { return path_; }
    [[nodiscard]] const RecordIdentity& identity() const { return identity_; }
    [[nodiscard]] std::vector<std::string> sections() const;  ///< names, without the identity's
    [[nodiscard]] bool has(std::string_view name) const;
    /// The content of a section. An Error if there is none of that name, or if it is damaged.
    [[nodiscard]] Result<std::string> read(std::string_view name) const;
    /// Checks every section.
    [[nodiscard]] Status check() const;

  private:
    struct Section {
        std::string name;
        std::uint64_t position = 0, size = 0, hash = 0;
    };
    [[nodiscard]] Result<std::string> content(const Section& section) const;
    std::string path_;
    RecordIdentity identity_;
    std::vector<Section> sections_;
};

/// The differences, one line each: "seed: 3 there, 4 here". Empty if both are equal. A field in only one of them is a
/// difference. Long values are shortened.
std::vector<std::string> identity_differences(const RecordIdentity& there, const RecordIdentity& here);

}  // namespace raylex::display
