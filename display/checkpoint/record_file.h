// The file around a record: named sections, each with a checksum, and an identity that says what the record is of. It
// is what checkpoints are written to; shards and experiment cells can be, too.
//
// Version 1, numbers in the order of the byte-order mark (little-endian on every machine raylex runs on):
//
//   8 bytes   89 "RLX" 0d 0a 1a 0a      as PNG begins: a transfer that changes line ends is seen here
//   u32       01020304                  byte-order mark
//   u32       1                         version of this layout
//   u64       number of sections
//   u64       XXH64 of the 24 bytes before
//   then for each section, the first of which is "identity":
//     u64 size of the name, u64 size of the content, u64 XXH64 of the content, u64 XXH64 of these 24 bytes and the name
//     the name, then the content
//   u64       XXH64 of all the sections' content hashes, and nothing after it
//
// So every bit of the file is under a checksum, and an end that is missing is seen.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "display/output/atomic_file.h"
#include "lpe/result.h"

namespace raylex::display {

/// What a record is of, line by line: {"seed", "3"}, {"resolution", "640x480"}. Order counts for messages only.
using RecordIdentity = std::vector<std::pair<std::string, std::string>>;

struct RecordSection {
    std::string name;  ///< unique within the record
    std::string content;
};

struct RecordFile {
    RecordIdentity identity;
    std::vector<RecordSection> sections;

    /// Null when there is none of that name.
    [[nodiscard]] const RecordSection* find(std::string_view name) const;
    /// Appends an empty one.
    std::string& add(std::string name);
};

/// Writes the record whole or not at all: a temporary file, synced, renamed, the folder synced. An earlier file at
/// `path` survives every failure.
Status write_record_file(const std::string& path, const RecordFile& record, FileSync sync = FileSync::now);

/// Reads and checks all of it. Errors name the file and what is wrong: no record file at all, another version or byte
/// order, truncated (with the byte), or damaged (with the section).
Result<RecordFile> read_record_file(const std::string& path);

/// The same file section by section, so that no more than one of them need be in memory.
class RecordFileWriter {
  public:
    /// `sections` is how many add() will be called for.
    static Result<RecordFileWriter> create(const std::string& path, const RecordIdentity& identity,
                                           std::size_t sections, FileSync sync = FileSync::now);
    Status add(const std::string& name, std::string_view content);
    Status commit();

  private:
    explicit RecordFileWriter(AtomicFile file) : file_(std::move(file)) {}
    AtomicFile file_;
    std::string hashes_;
};

/// A record file whose sections are read, and checked, one by one. No file stays open.
class RecordFileReader {
  public:
    /// Reads and checks what stands around the contents; a file that is too short for them is found here.
    static Result<RecordFileReader> open(const std::string& path);

    [[nodiscard]] const std::string& path() const { return path_; }
    [[nodiscard]] const RecordIdentity& identity() const { return identity_; }
    [[nodiscard]] std::vector<std::string> sections() const;  ///< names, without the identity's
    [[nodiscard]] bool has(std::string_view name) const;
    /// The content of a section; an Error when there is none of that name, or it is damaged.
    [[nodiscard]] Result<std::string> read(std::string_view name) const;
    /// Whether every section is sound.
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

/// What differs, one line each: "seed: 3 there, 4 here". Empty when the two say the same. Fields that only one of them
/// has differ too. Long values are cut.
std::vector<std::string> identity_differences(const RecordIdentity& there, const RecordIdentity& here);

}  // namespace raylex::display
