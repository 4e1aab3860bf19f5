// Files that come with raylex: cases of the stability suite, templates of job files, plugins.
#pragma once

#include <string>

#include "lpe/result.h"

namespace raylex::experiments {

/// Returns the path of a file or folder of raylex, such as "stability" or "plugins/libplanted_error.so". Searches
/// beside the program and the Python module, as a build folder has them, then below the prefix of either, as installed.
/// Error: none has it; the error names the path below the program's prefix.
Result<std::string> resource(const std::string& name);

}  // namespace raylex::experiments
