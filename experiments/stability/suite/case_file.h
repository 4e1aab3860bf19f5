// Reads files of cases.
#pragma once

#include <string>
#include <vector>

#include "experiments/stability/suite/stability_case.h"

namespace raylex::experiments {

/// Reads one family of cases. Loads the plugins of the file first, because cases may use their types. Errors name file,
/// line and column: invalid TOML, unknown keys, unknown probes.
Result<CaseFamily> read_case_file(const std::string& path);

/// Reads files, and all *.toml of folders by name. Errors: no file; two cases with the same name.
Result<std::vector<CaseFamily>> read_case_files(const std::vector<std::string>& paths);

}  // namespace raylex::experiments
