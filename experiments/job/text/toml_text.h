// TOML text into a table, with what toml++ does not guard against: tables inside one another without end, in which its
// tree, built and walked by recursion, takes the whole stack.
#pragma once

#include <string>
#include <string_view>

#include "experiments/job/text/toml_table.h"
#include "lpe/read_input.h"

namespace raylex::experiments {

/// A TOML file of at most Budget::toml_bytes.
Result<std::string> read_toml_file(const std::string& path, NamedBy by, const std::string& expected);

/// `text` of `path`. Errors with line and column: no TOML, tables and arrays deeper than Budget::toml_depth.
Result<toml::table> parse_toml(std::string_view text, const std::string& path);

/// Only the second: nothing when it is fit to be parsed.
Status check_toml_depth(std::string_view text, const std::string& path);

}  // namespace raylex::experiments
