#include "lpe/input/budgets.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <charconv>
#include <limits>

namespace raylex {

namespace {

constexpr std::uint64_t kilo = 1024, mega = kilo * kilo, giga = kilo * mega;
constexpr std::uint64_t any = std::numeric_limits<std::int64_t>::max();

// The depths are walked recursively: `most` is the depth that certainly fits a thread's stack of 8 MiB.
constexpr BudgetRow table[] = {
    {"file_bytes", 4 * giga, any, "one file of a scene: text, mesh, image"},
    {"text_bytes", 16 * mega, any, "a text file other than a scene: channels, vectors, spectrum"},
    {"pipe_bytes", 256 * mega, any, "input from a pipe or device named on the command line"},
    {"unpack_ratio", 100, any, "how many times its own size a compressed file may unpack to"},
    {"unpack_floor", 64 * mega, any, "bytes that any file may unpack to, however small it is"},
    {"exr_ratio", 1032, any, "as unpack_ratio, for OpenEXR: empty layers pack as well as deflate can"},
    {"image_pixels", 256 * mega, any, "pixels of one image"},
    {"mesh_rows", 512 * mega, 2 * giga - 1, "rows of one element of a PLY file: vertices, faces"},
    {"include_files", 10'000, any, "files that a scene includes or imports, each inclusion counts"},
    {"include_depth", 256, 4'096, "files that include one another"},
    {"include_repeats", 128 * mega, any, "bytes of files that are included again"},
    {"block_depth", 4'096, 65'536, "AttributeBegin, TransformBegin and ObjectBegin inside one another"},
    {"parameters", 4'096, 65'536,
     "parameters of one directive, repetitions included; parameters of a kind set by Attribute"},
    {"texture_depth", 512, 1'024, "textures that use one another in a row"},
    {"texture_work", 100'000, any, "texture lookups for one value"},
    {"material_depth", 256, 4'096, "mix materials inside one another"},
    {"toml_bytes", 4 * mega, any, "a TOML file: job, study, channels"},
    {"toml_depth", 100, 1'000, "tables and arrays of a TOML file inside one another"},
    {"record_bytes", 64 * mega, any, "a record of JSON: of a cell, a reference, a study, a render"},
    {"tessellated_triangles", 4 * mega, 512 * mega, "triangles that subdivision or displacement makes of one mesh"},
    {"volume_cells", 16 * mega, 1024 * mega, "cells of 8 x 8 x 8 voxels in the box around one grid of a medium"},
};

constexpr std::size_t count = std::size(table);
static_assert(count == static_cast<std::size_t>(Budget::volume_cells) + 1);

struct Values {
    std::array<std::atomic<std::uint64_t>, count> of{};
    Values() {
        for (std::size_t i = 0; i < count; ++i) of[i] = table[i].fallback;
    }
};

std::atomic<std::uint64_t>& value_of(std::size_t which) {
    static Values values;
    return values.of[which];
}

Error failure(std::string message) {
    return {std::move(message), "--budget", 0, 0, {}, {}};
}

/// Parses a whole number with an optional K, M or G; false when it is not a number or does not fit.
bool parse_value(std::string_view text, std::uint64_t& value) {
    std::uint64_t unit = 1;
    if (!text.empty()) {
        const char last = text.back();
        unit = last == 'K' ? kilo : last == 'M' ? mega : last == 'G' ? giga : 1;
        if (unit != 1) text.remove_suffix(1);
    }
    const char* const end = text.data() + text.size();
    const auto [stop, status] = std::from_chars(text.data(), end, value);
    if (status != std::errc() || stop != end || value > any / unit) return false;
    value *= unit;
    return true;
}

}  // namespace

std::span<const BudgetRow> budget_table() {
    return table;
}

std::uint64_t budget(Budget which) {
    return value_of(static_cast<std::size_t>(which));
}

Status set_budget(std::string_view assignment) {
    const std::size_t equals = assignment.find('=');
    const std::string_view name = assignment.substr(0, equals);
    const auto* const row =
        std::find_if(std::begin(table), std::end(table), [name](const BudgetRow& each) { return name == each.name; });
    if (equals == std::string_view::npos || row == std::end(table)) {
        std::string list;
        for (const BudgetRow& each : table) list += (list.empty() ? "" : ", ") + std::string(each.name);
        return failure("'" + std::string(assignment) +
                       "' names no budget; expected NAME=VALUE, where NAME is one of: " + list);
    }
    std::uint64_t value = 0;
    if (!parse_value(assignment.substr(equals + 1), value) || value == 0 || value > row->most)
        return failure("'" + std::string(assignment) + "' has an invalid value; expected a whole number from 1 to " +
                       std::to_string(row->most) + ", with an optional suffix K, M or G (powers of 1024)");
    value_of(static_cast<std::size_t>(row - std::begin(table))) = value;
    return success();
}

Status set_budgets(std::string_view assignments) {
    while (!assignments.empty()) {
        const std::size_t comma = assignments.find(',');
        const std::string_view one = assignments.substr(0, comma);
        if (Status set = set_budget(one); !set) return set;
        if (comma == std::string_view::npos) break;
        assignments.remove_prefix(comma + 1);
    }
    return success();
}

Error over_budget(Budget which, const std::string& what, const std::string& file, int line, int column) {
    const BudgetRow& row = table[static_cast<std::size_t>(which)];
    const std::uint64_t value = budget(which);
    Error error{what + "; the budget " + row.name + " is " + std::to_string(value), file, line, column, {}, {}};
    error.hint = "to allow this, raise the budget: --budget " + std::string(row.name) + "=VALUE (at most " +
                 std::to_string(row.most) + ")";
    if (row.most == any) error.hint.erase(error.hint.find(" (at most"));
    return error;
}

}  // namespace raylex
