// The files of a cell or a reference as its JSON lists them: what is damaged or gone is told from what was written.
#pragma once

#include <string>
#include <vector>

#include "experiments/study/results.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// Every file in the directory, by name, but for the JSON that will list them and checkpoints. XXH64 of the contents.
Result<std::vector<FileRecord>> file_records(const std::string& directory);

/// Which of the files is gone, of another size or of other content, as "FILE: what"; empty: none. All of it is read.
std::string damage_of(const std::string& directory, const std::vector<FileRecord>& files);

/// The same of a finished cell; of one that failed there is nothing to be damaged.
std::string damage_of(const Cell& cell);
/// Of a scene's reference, by its reference.json.
std::string damage_of_reference(const std::string& directory);

}  // namespace raylex::experiments
