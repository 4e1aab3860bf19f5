// Files of cases.
#pragma once

#include <string>
#include <vector>

#include "experiments/stability/suite/stability_case.h"

namespace raylex::experiments {

/// Reads one family. Plugins that the file names are loaded first, since cases may use what they bring. Errors name
/// file, line and column: TOML that does not parse, keys that nobody knows, probes that there are not.
Result<CaseFamily> read_case_file(const std::string& path);

/// Files as they are, and all *.toml of folders by name. Errors: nothing there; two cases of one name.
Result<std::vector<CaseFamily>> read_case_files(const std::vector<std::string>& paths);

/// The suite that comes with the program.
std::string shipped_stability_suite();

}  // namespace raylex::experiments
