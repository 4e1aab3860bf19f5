// Limits on external input: one table of names and numbers. Each default is above what sensible files need. Input above
// a limit is an Error that names the budget, its value, and the option that raises it. Limits on the language itself,
// which nobody needs to raise, are in lpe/limits.h.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "lpe/result.h"

namespace raylex {

enum class Budget : std::uint8_t {
    file_bytes,
    text_bytes,
    pipe_bytes,
    unpack_ratio,
    unpack_floor,
    exr_ratio,
    image_pixels,
    mesh_rows,
    include_files,
    include_depth,
    include_repeats,
    block_depth,
    parameters,
    texture_depth,
    texture_work,
    material_depth,
    toml_bytes,
    toml_depth,
    record_bytes,
    tessellated_triangles,
    volume_cells,
};

struct BudgetRow {
    const char* name;
    std::uint64_t fallback;
    std::uint64_t most;  ///< the largest permitted value: the limit of recursion or of 32-bit indices
    const char* meaning;
};

/// The budgets in the order of the enum Budget.
[[nodiscard]] std::span<const BudgetRow> budget_table();

[[nodiscard]] std::uint64_t budget(Budget which);

/// Sets a budget for the whole program; call it before any input is read. `assignment` is "NAME=VALUE"; the value is a
/// whole number with an optional K, M or G (powers of 1024). Errors: unknown name (the message lists all names), not a
/// number, value above the limit of the row.
Status set_budget(std::string_view assignment);
/// Sets several budgets, separated by commas; "" sets none.
Status set_budgets(std::string_view assignments);

/// The error "WHAT; the budget NAME is VALUE". Its hint gives the option that raises the budget.
[[nodiscard]] Error over_budget(Budget which, const std::string& what, const std::string& file, int line = 0,
                                int column = 0);

}  // namespace raylex
