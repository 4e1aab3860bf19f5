// Converts the words of an atlas to header attributes and back. Private to the atlas's files.
#pragma once

#include <map>
#include <string>

#include "display/output/atlas/atlas_file.h"

namespace raylex::display {

std::map<std::string, std::string> table_attributes(const PathStringTable& table);
/// Parses the attributes. Errors name `path` and the problem.
Result<PathStringTable> read_table(const std::map<std::string, std::string>& attributes, const std::string& path);

}  // namespace raylex::display
