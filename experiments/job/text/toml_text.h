// Parses TOML text. Limits the nesting depth first, because toml++ builds and walks its tree recursively and would
// exhaust the stack.
#pragma once

#include <string>
#include <string_view>

#include "experiments/job/text/toml_table.h"
#include "lpe/input/read_input.h"

namespace raylex::experiments {

/// Reads a TOML file of at most Budget::toml_bytes.
Result<std::string> read_toml_file(const std::string& path, NamedBy by, const std::string& expected);

/// Parses `text` from the file `path`. Errors with line and column: not valid TOML, tables and arrays deeper than
/// Budget::toml_depth.
Result<toml::table> parse_toml(std::string_view text, const std::string& path);

/// Checks only the nesting depth; returns success if the text can be parsed safely.
Status check_toml_depth(std::string_view text, const std::string& path);

}  // namespace raylex::experiments
