// The values that one key of an experiment goes through.
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "experiments/job/text/toml_table.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// One value of a setting, as TOML has it.
struct AxisValue {
    std::variant<bool, std::int64_t, double, std::string> value;

    [[nodiscard]] std::string text() const;  ///< for names and tables: "8", "0.5", "sobol"
};

/// A single value, a list of values, a range "1..8" or "1..9 step 2" (both ends count), or "pow2(0..10)". Errors at the
/// value: anything else, an empty list, a range that runs backwards, equal values, more than 10,000 of them.
Result<std::vector<AxisValue>> read_axis(const TomlSource& source, const toml::node& node, const std::string& what);

}  // namespace raylex::experiments
