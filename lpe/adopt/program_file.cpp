#include "lpe/adopt/program_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>
#include <system_error>
#include <utility>

#include "lpe/failure.h"
#include "lpe/input/read_input.h"
#include "lpe/language/pattern.h"
#include "lpe/limits.h"

namespace raylex::lpe {

namespace {

constexpr std::string_view magic = "RAYLEXPG";
constexpr std::uint32_t version = 1;
constexpr std::size_t hash_bytes = 8;

/// The 64-bit FNV-1a hash (Fowler, Noll, Vo).
std::uint64_t hash_of(std::string_view bytes) {
    std::uint64_t hash = 0xCBF29CE484222325ULL;
    for (const char byte : bytes) { hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001B3ULL; }
    return hash;
}

/// Visits every part of the tables in the order of the file. Reader and writer share this order because both use it.
template <class Tables, class Visitor>
void visit_tables(Tables& tables, Visitor& visitor) {
    visitor.texts(tables.channel_names);
    visitor.number(tables.table_count);
    visitor.number(tables.class_count);
    visitor.array(tables.starts);
    visitor.array(tables.next_state);
    visitor.array(tables.accept_begin);
    visitor.array(tables.accept_lists);
    for (auto& words : tables.parallel_words) { visitor.number(words); }
    visitor.number(tables.first_ended);
    visitor.array(tables.parallel_masks);
    visitor.array(tables.parallel_accept);
    visitor.array(tables.parallel_lists);
    visitor.array(tables.classes.node_of_core);
    visitor.records(tables.classes.nodes);
    visitor.records(tables.classes.names);
    visitor.array(tables.classes.globs);
    visitor.records(tables.classes.kinds);
    visitor.array(tables.classes.matches);
    visitor.array(tables.classes.text_begin);
    visitor.text(tables.classes.characters);
    visitor.array(tables.column_of_class);
}

class ByteWriter {
  public:
    std::string bytes;

    template <class Integer>
    void number(Integer value) {
        for (std::size_t byte = 0; byte < sizeof value; ++byte) {
            bytes += static_cast<char>(static_cast<std::uint64_t>(value) >> 8 * byte & 0xFF);
        }
    }
    template <class Integer>
    void array(const std::vector<Integer>& values) {
        number(std::uint64_t{values.size()});
        for (const Integer value : values) { number(value); }
    }
    /// Structures whose fields are all 32-bit numbers.
    template <class Record>
    void records(const std::vector<Record>& values) {
        number(std::uint64_t{values.size()});
        for (const Record& value : values) {
            for (const std::uint32_t field : std::bit_cast<std::array<std::uint32_t, sizeof(Record) / 4>>(value)) {
                number(field);
            }
        }
    }
    void text(const std::string& value) {
        number(std::uint64_t{value.size()});
        bytes += value;
    }
    void texts(const std::vector<std::string>& values) {
        number(std::uint64_t{values.size()});
        for (const std::string& value : values) { text(value); }
    }
};

class Reader {
  public:
    explicit Reader(std::string_view bytes) : bytes_(bytes) {}

    template <class Integer>
    void number(Integer& value) {
        need(sizeof value, 1);
        std::uint64_t sum = 0;
        for (std::size_t byte = 0; byte < sizeof value; ++byte) {
            sum |= std::uint64_t{static_cast<unsigned char>(bytes_[at_++])} << 8 * byte;
        }
        value = static_cast<Integer>(sum);
    }
    template <class Integer>
    void array(std::vector<Integer>& values) {
        values.resize(count(sizeof(Integer)));
        for (Integer& value : values) { number(value); }
    }
    template <class Record>
    void records(std::vector<Record>& values) {
        values.resize(count(sizeof(Record)));
        for (Record& value : values) {
            std::array<std::uint32_t, sizeof(Record) / 4> fields;
            for (std::uint32_t& field : fields) { number(field); }
            value = std::bit_cast<Record>(fields);
        }
    }
    void text(std::string& value) {
        const std::size_t size = count(1);
        value.assign(bytes_.substr(at_, size));
        at_ += size;
    }
    void texts(std::vector<std::string>& values) {
        values.resize(count(8));
        for (std::string& value : values) { text(value); }
    }
    [[nodiscard]] std::size_t position() const { return at_; }
    [[nodiscard]] bool at_end() const { return at_ == bytes_.size(); }

  private:
    /// Reads a count. It fails, before any memory is allocated, if the remaining bytes cannot hold that many elements.
    std::size_t count(std::size_t element_bytes) {
        std::uint64_t value = 0;
        number(value);
        need(value, element_bytes);
        return static_cast<std::size_t>(value);
    }
    void need(std::uint64_t elements, std::size_t element_bytes) const {
        if (elements > (bytes_.size() - at_) / element_bytes) {
            fail("the compiled program ends early: byte " + std::to_string(at_) + ": expected " +
                 std::to_string(elements) + " elements of " + std::to_string(element_bytes) + " bytes, but only " +
                 std::to_string(bytes_.size() - at_) + " bytes are left");
        }
    }

    std::string_view bytes_;
    std::size_t at_ = 0;
};

void require(bool holds, const char* what) {
    if (!holds) { fail(std::string("the compiled program contradicts itself: ") + what); }
}

template <class Integer>
void require_below(const std::vector<Integer>& values, std::uint64_t bound, const char* what) {
    require(std::all_of(values.begin(), values.end(), [bound](Integer value) { return value < bound; }), what);
}

/// Checks the offsets of consecutive ranges of an array: ascending and at most `size`.
void require_offsets(const std::vector<std::uint32_t>& offsets, std::uint64_t size, const char* what) {
    require(!offsets.empty() && std::is_sorted(offsets.begin(), offsets.end()) && offsets.back() <= size, what);
}

bool within(std::uint64_t first, std::uint64_t count, std::uint64_t size) {
    return first + count <= size;
}

void check_classes(const ClassTable& table, std::size_t class_count) {
    const std::size_t nodes = table.nodes.size();
    require_offsets(table.text_begin, table.characters.size(), "label texts");
    const std::size_t texts = table.text_begin.size() - 1;
    require(table.node_of_core.size() == core_count, "kinds of events");
    require_below(table.node_of_core, nodes, "kinds of events");
    require_below(table.globs, texts, "globs");
    for (const ClassTable::Node& node : table.nodes) {
        require(node.end_class < class_count && within(node.first_name, node.names, table.names.size()) &&
                    within(node.first_glob, node.globs, table.globs.size()) &&
                    within(node.first_kind, node.kinds, table.kinds.size()),
                "nodes of the event classes");
        for (std::uint32_t k = 0; k < node.kinds; ++k) {
            require(within(table.kinds[node.first_kind + k].first_match, node.globs, table.matches.size()),
                    "matches of globs");
        }
    }
    for (const ClassTable::Name& name : table.names) {
        require(name.text < texts && name.node < nodes, "names of labels");
    }
    for (const ClassTable::Kind& kind : table.kinds) { require(kind.node < nodes, "kinds of labels"); }
}

void check_parallel(const ProgramTables& tables, std::uint64_t states) {
    constexpr std::uint32_t most_words = 1U << 16;
    require(std::all_of(tables.parallel_words.begin(), tables.parallel_words.end(),
                        [](std::uint32_t n) { return n < most_words; }),
            "words of packed channels");
    const ProgramView view = tables.view();
    const std::uint64_t parallel_words = view.widths.back().state;
    require(tables.starts.size() == tables.table_count + parallel_words, "words of state");
    if (parallel_words == 0) { return; }
    require(tables.table_count >= 1 && tables.first_ended >= 2 && tables.first_ended <= states, "phases of a path");
    const std::uint64_t terminals = states - tables.first_ended;
    require(tables.parallel_masks.size() == std::uint64_t{tables.class_count} * view.mask_stride,
            "transition masks of packed channels");
    for (std::size_t last = view.mask_stride - 1; last < tables.parallel_masks.size(); last += view.mask_stride) {
        require(tables.parallel_masks[last] < states, "phases of a path");
    }
    require(tables.parallel_accept.size() == terminals * view.accept_stride, "acceptance of packed channels");
    require(tables.parallel_lists.size() == terminals * view.widths.back().lists + 1, "channels of packed channels");
    require_offsets(tables.parallel_lists, tables.accept_lists.size(), "channels of packed channels");
}

void check_tables(const ProgramTables& tables) {
    require(tables.class_count >= 1 && tables.class_count <= 1U + std::numeric_limits<EventClass>::max(),
            "event classes");
    require_offsets(tables.accept_begin, tables.accept_lists.size(), "accept lists");
    require(tables.accept_begin.size() >= 2 && tables.accept_begin[0] == 0 && tables.accept_begin[1] == 0,
            "the dead state");
    const std::uint64_t states = tables.accept_begin.size() - 1;
    require(tables.next_state.size() == states * tables.class_count, "the transition table");
    require_below(tables.next_state, states, "the transition table");
    require(std::all_of(tables.next_state.begin(), tables.next_state.begin() + tables.class_count,
                        [](State state) { return state == ProgramView::dead; }),
            "the dead state");
    require(tables.channel_names.size() <= limits::channels, "channels");
    require_below(tables.accept_lists, tables.channel_names.size(), "channels in accept lists");
    require(tables.table_count <= tables.starts.size(), "words of state");
    for (std::size_t word = 0; word < tables.table_count; ++word) {
        require(tables.starts[word] < states, "start states");
    }
    check_parallel(tables, states);
    if (tables.column_of_class.empty()) {
        return;  // a program without channels
    }
    require_below(tables.column_of_class, tables.class_count, "columns of event classes");
    check_classes(tables.classes, tables.column_of_class.size());
}

Program read(std::string_view bytes) {
    if (bytes.substr(0, magic.size()) != magic) {
        fail("not a compiled program: expected '" + std::string(magic) + "' at its beginning",
             "compiled programs are written by raylex::lpe::save");
    }
    Reader reader(bytes.substr(magic.size()));
    std::uint32_t found = 0;
    reader.number(found);
    if (found != version) {
        fail("the compiled program is of version " + std::to_string(found) + "; expected version " +
                 std::to_string(version),
             "compile the channels again");
    }
    if (bytes.size() < magic.size() + sizeof found + hash_bytes) { fail("the compiled program ends early"); }
    Reader ending(bytes.substr(bytes.size() - hash_bytes));
    std::uint64_t hash = 0;
    ending.number(hash);
    const std::string_view content = bytes.substr(0, bytes.size() - hash_bytes);
    if (hash != hash_of(content)) {
        fail("the compiled program is damaged or cut short: its hash does not match its content");
    }
    Reader body(content.substr(magic.size() + sizeof found));
    ProgramTables tables;
    visit_tables(tables, body);
    require(body.at_end(), "bytes after its end");
    check_tables(tables);
    return Program(std::move(tables));
}

Error file_error(const std::string& path, const std::string& what) {
    Error error;
    error.message = what;
    error.file = path;
    return error;
}

}  // namespace

std::string to_bytes(const Program& program) {
    ByteWriter writer;
    writer.bytes = magic;
    writer.number(version);
    visit_tables(program.tables(), writer);
    writer.number(hash_of(writer.bytes));
    return std::move(writer.bytes);
}

Result<Program> program_from_bytes(std::string_view bytes, const std::string& origin) {
    Result<Program> program = guarded([&] { return read(bytes); });
    if (!program) {
        Error error = std::move(program).error();
        error.file = origin;
        return error;
    }
    return program;
}

Status save(const Program& program, const std::string& path) {
    const std::string bytes = to_bytes(program);
    const std::string temporary = path + ".partial";
    {
        std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
        file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
        file.close();
        if (!file) {
            std::remove(temporary.c_str());
            return file_error(path, "the compiled program cannot be written");
        }
    }
    std::error_code code;
    std::filesystem::rename(temporary, path, code);
    if (code) {
        std::remove(temporary.c_str());
        return file_error(path, "the compiled program cannot be renamed to its final name: " + code.message());
    }
    return success();
}

Result<Program> load(const std::string& path) {
    const auto bytes = read_input(path, NamedBy::file, "a compiled program", Budget::file_bytes);
    if (!bytes) { return bytes.error(); }
    return program_from_bytes(*bytes, path);
}

}  // namespace raylex::lpe
