// Files that come with raylex: cases of the stability suite, templates of job files, plugins.
#pragma once

#include <string>

#include "lpe/result.h"

namespace raylex::experiments {

/// Returns the path of a file or folder of raylex, such as "stability" or "plugins/libplanted_error.so". Searches
/// beside the program and the Python module, as a build folder has them, then below the prefix of either, as installed.
/// If none has it, returns the path below the program's prefix, for the error message.
std::string resource(const std::string& name);
/// The same, with an error if none has it.
Result<std::string> needed_resource(const std::string& name);

}  // namespace raylex::experiments
