// The values of one key of an experiment.
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "experiments/job/text/toml_table.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// One value of a setting, with its TOML type.
struct AxisValue {
    std::variant<bool, std::int64_t, double, std::string> value;

    [[nodiscard]] std::string text() const;  ///< for names and tables: "8", "0.5", "sobol"
};

/// Reads a value, a list of values, a range "1..8" or "1..9 step 2" (inclusive), or "pow2(0..10)". Errors at the value:
/// anything else, an empty list, a reversed range, equal values, more than 10,000 values.
Result<std::vector<AxisValue>> read_axis(const TomlSource& source, const toml::node& node, const std::string& what);

}  // namespace raylex::experiments
