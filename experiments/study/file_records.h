// Records of the files of a cell or reference in its JSON, which show missing and damaged files.
#pragma once

#include <string>
#include <vector>

#include "experiments/study/results.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// Returns a record of every file in the directory, by name, except checkpoints and the JSON that will contain the
/// records. Hashes are XXH64.
Result<std::vector<FileRecord>> file_records(const std::string& directory);

/// Returns the first file that is missing or has another size or content, as "FILE: what"; empty if there is none.
/// Reads all files.
std::string damage_of(const std::string& directory, const std::vector<FileRecord>& files);

/// Returns the damage of a finished cell. A failed cell has no files.
std::string damage_of(const StudyRun& run);
/// Returns the damage of a scene's reference, from its reference.json.
std::string damage_of_reference(const std::string& directory);

}  // namespace raylex::experiments
