#include "transport/plugins/plugin_file.h"

#include <elf.h>

#include <algorithm>
#include <cstring>
#include <optional>
#include <span>
#include <type_traits>

#include "display/services/processor.h"
#include "lpe/input/read_input.h"

namespace raylex::transport {
namespace {

static_assert(std::is_trivially_copyable_v<PluginStamp>);

/// A record at an offset of the file, if the file contains all of it.
template <class Record>
std::optional<Record> record_at(std::span<const char> bytes, std::uint64_t offset) {
    if (offset > bytes.size() || bytes.size() - offset < sizeof(Record)) return std::nullopt;
    Record record;
    std::memcpy(&record, bytes.data() + offset, sizeof(Record));
    return record;
}

/// The contents of the section with that name; empty if there is none.
std::span<const char> section_of(std::span<const char> bytes, const Elf64_Ehdr& header, std::string_view name) {
    const auto section = [&](std::uint64_t index) {
        return record_at<Elf64_Shdr>(bytes, header.e_shoff + index * sizeof(Elf64_Shdr));
    };
    const auto contents = [&](const Elf64_Shdr& s) -> std::span<const char> {
        if (s.sh_type == SHT_NOBITS || s.sh_offset > bytes.size() || bytes.size() - s.sh_offset < s.sh_size) return {};
        return bytes.subspan(s.sh_offset, s.sh_size);
    };
    if (header.e_shentsize != sizeof(Elf64_Shdr)) return {};
    const auto names_section = section(header.e_shstrndx);
    if (!names_section) return {};
    const std::span<const char> names = contents(*names_section);
    for (std::uint64_t i = 0; i < header.e_shnum; ++i) {
        const auto each = section(i);
        if (!each || each->sh_name >= names.size()) continue;
        const std::string_view rest(names.data() + each->sh_name, names.size() - each->sh_name);
        if (rest.substr(0, rest.find('\0')) == name) return contents(*each);
    }
    return {};
}

/// The text of a field, which may lack its terminator in a damaged file.
template <std::size_t Size>
std::string text_of(const std::array<char, Size>& field) {
    return {field.data(), static_cast<std::size_t>(std::find(field.begin(), field.end(), '\0') - field.begin())};
}

}  // namespace

Result<PluginStamp> read_plugin_stamp(const std::string& file, const SourceLocation& where) {
    const auto content = read_input(file, NamedBy::file, "a shared library", Budget::file_bytes);
    if (!content)
        return error_at(where, "cannot read plugin '" + file + "': " + content.error().message, content.error().hint);
    const std::span<const char> bytes(*content);
    const auto header = record_at<Elf64_Ehdr>(bytes, 0);
    if (!header || std::memcmp(header->e_ident, ELFMAG, SELFMAG) != 0 || header->e_ident[EI_CLASS] != ELFCLASS64 ||
        header->e_ident[EI_DATA] != ELFDATA2LSB || header->e_type != ET_DYN)
        return error_at(where,
                        "plugin '" + file + "' is not a shared library; expected the output of raylex_add_plugin()");
    if (header->e_machine != display::elf_machine)
        return error_at(
            where, "plugin '" + file + "' was built for another kind of machine; expected a plugin for this machine");
    const std::span<const char> section = section_of(bytes, *header, PluginStamp::section);
    if (section.empty())
        return error_at(where, "'" + file +
                                   "' is a shared library but not a raylex plugin; expected one with "
                                   "RAYLEX_PLUGIN(host) { ... }");
    std::array<char, 24> magic{}, version{};
    if (section.size() >= magic.size() + version.size()) {
        std::copy_n(section.begin(), magic.size(), magic.begin());
        std::copy_n(section.begin() + magic.size(), version.size(), version.begin());
    }
    const auto stamp = record_at<PluginStamp>(section, 0);
    if (section.size() != sizeof(PluginStamp) || !stamp || text_of(magic) != PluginStamp::magic_text)
        return error_at(where, "plugin '" + file + "' has a stamp in another format" +
                                   (text_of(version).empty() ? "" : ", of raylex " + text_of(version)) +
                                   "; expected one built for this raylex, " RAYLEX_PLUGIN_VERSION);
    return *stamp;
}

Status check_plugin_stamp(const PluginStamp& stamp, const std::string& file, const SourceLocation& where) {
    const PluginStamp own = make_plugin_stamp();
    const auto refuse = [&](const std::string& difference) {
        return error_at(where, "plugin '" + file + "' does not match this program: " + difference,
                        "build it again with this raylex: find_package(raylex) and the same compiler");
    };
    if (stamp.version != own.version)
        return refuse("it was built for raylex " + text_of(stamp.version) + ", but this program is " +
                      text_of(own.version));
    if (stamp.compiler != own.compiler)
        return refuse("it was built by " + text_of(stamp.compiler) + ", but this program by " + text_of(own.compiler));
    if (stamp.standard_library != own.standard_library)
        return refuse("it was built with " + text_of(stamp.standard_library) + ", but this program with " +
                      text_of(own.standard_library));
    if (stamp.interface != own.interface)
        return refuse("it was built with other headers of raylex " + text_of(own.version) + " than this program");
    for (std::size_t i = 0; i < own.layout.size(); ++i)
        if (stamp.layout[i] != own.layout[i])
            return refuse(std::string(plugin_layout_names[i]) + " has " + std::to_string(stamp.layout[i]) +
                          " bytes in it and " + std::to_string(own.layout[i]) +
                          " in this program: compiler options differ");
    return success();
}

}  // namespace raylex::transport
