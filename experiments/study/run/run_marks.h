// What a run that may be begun again and again leaves beside its results: that it began, that it is done, or why it
// ended. A queue's tasks and 'raylex status' go by it.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "experiments/study/run/runner.h"
#include "lpe/result.h"

namespace raylex::experiments {

struct RunMark {
    std::string config_hash;
    Shard shard;
    bool only_references = false;
    std::size_t done = 0, failed = 0;  ///< cells and parts of cells, and references that could not be made
};

/// DIR/finished.json: there once all that a run was to do is done or has failed.
std::string finished_file(const std::string& directory);
/// Whether a file in a directory of results is one of these.
bool is_run_mark(const std::string& name);

/// Makes the directory and says that a run of this shard began; what an earlier one left is taken away.
Status mark_begun(const std::string& directory, const RunMark& mark);
Status mark_finished(const std::string& directory, const RunMark& mark);
/// As far as the disk takes it: there may be no space left, and the message stands on the terminal too.
void mark_error(const std::string& directory, const Error& error);

/// Nothing where there is none, or none that can be read.
std::optional<RunMark> begun_mark(const std::string& directory);
std::optional<RunMark> finished_mark(const std::string& directory);
/// Whether it finished, and no cell failed.
bool is_done(const std::string& directory);
/// What ended the last run; empty where nothing did.
std::string error_mark(const std::string& directory);

}  // namespace raylex::experiments
