#include "display/checkpoint/record_file.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <limits>
#include <memory>

#include <sys/stat.h>

#include "display/buffer/record_bytes.h"
#include "display/services/hash64.h"
#include "lpe/input/read_input.h"

namespace raylex::display {
namespace {

constexpr std::string_view magic = "\x89RLX\r\n\x1a\n";
constexpr std::uint32_t byte_order_mark = 0x01020304, version = 1;
constexpr std::size_t header_size = 32, section_header_size = 32;
constexpr std::uint64_t longest_name = 4096;

Error file_error(const std::string& path, std::string message, std::string hint = {}) {
    return {std::move(message), path, 0, 0, {}, std::move(hint)};
}

std::string identity_text(const RecordIdentity& identity) {
    std::string bytes;
    RecordWriter writer(bytes);
    writer.number(static_cast<std::uint64_t>(identity.size()));
    for (const auto& [name, value] : identity) {
        writer.text(name);
        writer.text(value);
    }
    return bytes;
}

bool read_identity(std::string_view bytes, RecordIdentity& identity) {
    RecordReader reader(bytes);
    const auto count = reader.number<std::uint64_t>();
    for (std::uint64_t i = 0; i < count && reader.ok(); ++i) {
        std::string name = reader.text();
        identity.emplace_back(std::move(name), reader.text());
    }
    return reader.at_end();
}

struct FileCloser {
    void operator()(std::FILE* file) const { std::fclose(file); }
};

/// Reads a record file from front to back; the first problem becomes `error`.
class Reading {
  public:
    Reading(std::FILE* file, const std::string& path) : file_(file), path_(path) {}

    bool take(std::string& bytes, std::uint64_t size) {
        bytes.clear();
        // Reads in pieces, so that a wrong size needs no more memory than the file has bytes.
        constexpr std::uint64_t piece = std::uint64_t{1} << 24;
        while (size > 0) {
            const auto part = static_cast<std::size_t>(std::min(size, piece));
            const std::size_t before = bytes.size();
            bytes.resize(before + part);
            const std::size_t got = std::fread(bytes.data() + before, 1, part, file_);
            position_ += got;
            size -= got;
            if (got < part)
                return std::ferror(file_) != 0
                           ? fail(std::string("cannot read the file: ") + std::strerror(errno))
                           : fail("the file is truncated: it ends after " + std::to_string(position_) + " bytes");
        }
        return true;
    }
    /// Skips bytes that must exist.
    bool skip(std::uint64_t size) {
        struct stat status {};
        if (fstat(fileno(file_), &status) != 0)
            return fail(std::string("cannot read the file: ") + std::strerror(errno));
        const auto end = static_cast<std::uint64_t>(status.st_size);
        if (size > end - std::min(end, position_))
            return fail("the file is truncated: it ends after " + std::to_string(end) + " bytes");
        position_ += size;
        return fseeko(file_, static_cast<off_t>(position_), SEEK_SET) == 0 ||
               fail(std::string("cannot read the file: ") + std::strerror(errno));
    }
    [[nodiscard]] std::uint64_t position() const { return position_; }
    bool fail(std::string message) {
        error = file_error(path_, std::move(message), "none of it is used; replace it by an intact copy");
        return false;
    }
    bool at_end() {
        return std::fgetc(file_) == EOF ? true : fail("the file has extra bytes after its end: it is damaged");
    }
    Error error;

  private:
    std::FILE* file_;
    const std::string& path_;
    std::uint64_t position_ = 0;
};

bool read_header(Reading& file, std::uint64_t& sections) {
    std::string bytes;
    if (!file.take(bytes, header_size)) return false;
    if (bytes.substr(0, magic.size()) != magic) return file.fail("not a raylex record; expected its magic number");
    RecordReader reader(std::string_view(bytes).substr(magic.size()));
    const auto mark = reader.number<std::uint32_t>(), found = reader.number<std::uint32_t>();
    sections = reader.number<std::uint64_t>();
    if (mark != byte_order_mark)
        return file.fail(mark == 0x04030201 ? "the record was written on a machine with a different byte order"
                                            : "the record's header is damaged");
    if (reader.number<std::uint64_t>() != hash64({bytes.data(), header_size - 8}))
        return file.fail("the record's header is damaged");
    if (found != version)
        return file.fail("the record has version " + std::to_string(found) + "; expected version " +
                         std::to_string(version));
    return true;
}

/// Reads a section up to its content.
bool read_section_header(Reading& file, std::string& name, std::uint64_t& size, std::uint64_t& hash) {
    std::string header;
    if (!file.take(header, section_header_size)) return false;
    RecordReader reader(header);
    const auto name_size = reader.number<std::uint64_t>();
    size = reader.number<std::uint64_t>();
    hash = reader.number<std::uint64_t>();
    const auto header_hash = reader.number<std::uint64_t>();
    if (name_size > longest_name) return file.fail("a section's header is damaged");
    if (!file.take(name, name_size)) return false;
    if (hash64(header.substr(0, section_header_size - 8) + name) != header_hash)
        return file.fail("a section's header is damaged");
    return true;
}

std::string damaged(const std::string& section) {
    return "section '" + section + "' is damaged: its checksum does not match";
}

std::string shortened(const std::string& text) {
    constexpr std::size_t most = 60;
    return text.size() <= most ? text : text.substr(0, most) + "...";
}

}  // namespace

const RecordSection* RecordFile::find(std::string_view name) const {
    const auto found = std::find_if(sections.begin(), sections.end(),
                                    [&](const RecordSection& section) { return section.name == name; });
    return found == sections.end() ? nullptr : &*found;
}

std::string& RecordFile::add(std::string name) {
    sections.push_back({std::move(name), {}});
    return sections.back().content;
}

Result<RecordFileWriter> RecordFileWriter::create(const std::string& path, const RecordIdentity& identity,
                                                  std::size_t sections, FileSync sync) {
    auto file = AtomicFile::create(path, sync);
    if (!file) return file.error();
    RecordFileWriter writer(*std::move(file));
    std::string header(magic);
    RecordWriter fields(header);
    fields.number(byte_order_mark);
    fields.number(version);
    fields.number(static_cast<std::uint64_t>(sections + 1));
    fields.number(hash64(header));
    if (!writer.file_.write(header.data(), header.size())) return writer.file_.failure();
    if (Status added = writer.add("identity", identity_text(identity)); !added) return added.error();
    return writer;
}

Status RecordFileWriter::add(const std::string& name, std::string_view content) {
    const std::uint64_t hash = hash64(content);
    std::string section;
    RecordWriter fields(section);
    fields.number(static_cast<std::uint64_t>(name.size()));
    fields.number(static_cast<std::uint64_t>(content.size()));
    fields.number(hash);
    fields.number(hash64(section + name));
    section += name;
    RecordWriter(hashes_).number(hash);
    if (file_.write(section.data(), section.size()) && file_.write(content.data(), content.size())) return success();
    return file_.failure();
}

Status RecordFileWriter::commit() {
    std::string end;
    RecordWriter(end).number(hash64(hashes_));
    if (!file_.write(end.data(), end.size())) return file_.failure();
    return file_.commit();
}

Status write_record_file(const std::string& path, const RecordFile& record, FileSync sync) {
    auto writer = RecordFileWriter::create(path, record.identity, record.sections.size(), sync);
    if (!writer) return writer.error();
    for (const RecordSection& section : record.sections)
        if (Status added = writer->add(section.name, section.content); !added) return added;
    return writer->commit();
}

Result<RecordFileReader> RecordFileReader::open(const std::string& path) {
    if (Status regular = check_regular_file(path, "a raylex record"); !regular) return regular.error();
    const std::unique_ptr<std::FILE, FileCloser> handle(std::fopen(path.c_str(), "rb"));
    if (!handle) return file_error(path, std::string("cannot read the file: ") + std::strerror(errno));
    Reading file(handle.get(), path);
    std::uint64_t count = 0;
    if (!read_header(file, count)) return file.error;
    RecordFileReader record;
    record.path_ = path;
    std::string hashes;
    for (std::uint64_t i = 0; i < count; ++i) {
        Section section;
        if (!read_section_header(file, section.name, section.size, section.hash)) return file.error;
        section.position = file.position();
        RecordWriter(hashes).number(section.hash);
        if (i > 0) {
            if (!file.skip(section.size)) return file.error;
            record.sections_.push_back(std::move(section));
            continue;
        }
        std::string content;
        if (!file.take(content, section.size)) return file.error;
        if (hash64(content) != section.hash) file.fail(damaged(section.name));
        else if (section.name == "identity" && read_identity(content, record.identity_)) continue;
        else file.fail("the record has no identity: it is damaged");
        return file.error;
    }
    std::string end;
    if (!file.take(end, sizeof(std::uint64_t))) return file.error;
    if (RecordReader(end).number<std::uint64_t>() != hash64(hashes)) {
        file.fail("the end of the record is damaged");
        return file.error;
    }
    if (!file.at_end()) return file.error;
    return record;
}

std::vector<std::string> RecordFileReader::sections() const {
    std::vector<std::string> names;
    for (const Section& section : sections_) names.push_back(section.name);
    return names;
}

bool RecordFileReader::has(std::string_view name) const {
    return std::any_of(sections_.begin(), sections_.end(), [&](const Section& each) { return each.name == name; });
}

Result<std::string> RecordFileReader::read(std::string_view name) const {
    for (const Section& section : sections_)
        if (section.name == name) return content(section);
    return file_error(path_, "the record has no section '" + std::string(name) + "'");
}

Status RecordFileReader::check() const {
    for (const Section& section : sections_)
        if (const auto sound = content(section); !sound) return sound.error();
    return success();
}

Result<std::string> RecordFileReader::content(const Section& section) const {
    const std::unique_ptr<std::FILE, FileCloser> handle(std::fopen(path_.c_str(), "rb"));
    if (!handle) return file_error(path_, std::string("cannot read the file: ") + std::strerror(errno));
    Reading file(handle.get(), path_);
    std::string bytes;
    if (!file.skip(section.position)) return file.error;
    bytes.reserve(section.size);  // open() checked the size
    if (!file.take(bytes, section.size)) return file.error;
    if (hash64(bytes) == section.hash) return bytes;
    file.fail(damaged(section.name));
    return file.error;
}

Result<RecordFile> read_record_file(const std::string& path) {
    auto reader = RecordFileReader::open(path);
    if (!reader) return reader.error();
    RecordFile record;
    record.identity = reader->identity();
    for (std::string& name : reader->sections()) {
        auto content = reader->read(name);
        if (!content) return content.error();
        record.sections.push_back({std::move(name), *std::move(content)});
    }
    return record;
}

std::vector<std::string> identity_differences(const RecordIdentity& there, const RecordIdentity& here) {
    const auto value_in = [](const RecordIdentity& identity, const std::string& name) -> const std::string* {
        for (const auto& [key, value] : identity)
            if (key == name) return &value;
        return nullptr;
    };
    std::vector<std::string> differences;
    for (const auto& [name, value] : there) {
        const std::string* other = value_in(here, name);
        if (other != nullptr && *other == value) continue;
        differences.push_back(name + ": " + shortened(value) + " there, " +
                              (other != nullptr ? shortened(*other) : std::string("nothing")) + " here");
    }
    for (const auto& [name, value] : here)
        if (value_in(there, name) == nullptr)
            differences.push_back(name + ": nothing there, " + shortened(value) + " here");
    return differences;
}

}  // namespace raylex::display
