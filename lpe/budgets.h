// What a reader may spend on something that comes from outside: one table of names and numbers. Each is above what
// honest files need; what exceeds one is an Error that names the budget, its value and how to raise it. Bounds on the
// language itself, which nobody has to raise, stand in lpe/limits.h.
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
    std::uint64_t most;  ///< to which it can be raised: what recursion or 32-bit indices hold
    const char* meaning;
};

/// In the order of Budget.
[[nodiscard]] std::span<const BudgetRow> budget_table();

[[nodiscard]] std::uint64_t budget(Budget which);

/// "NAME=VALUE", the value a whole number with K, M or G (powers of 1024) behind it or nothing. For the whole program,
/// before anything is read. Errors: an unknown name (with all there are), no number, more than the row allows.
Status set_budget(std::string_view assignment);
/// The same for several, parted by commas; nothing for "".
Status set_budgets(std::string_view assignments);

/// "WHAT; the budget NAME is VALUE", with how to raise it as the hint.
[[nodiscard]] Error over_budget(Budget which, const std::string& what, const std::string& file, int line = 0,
                                int column = 0);

}  // namespace raylex
