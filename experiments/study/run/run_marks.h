// Marks of a repeatable run beside its results: that it began, that it is finished, or why it ended. Queues and 'raylex
// status' use them.
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
    std::size_t done = 0, failed = 0;  ///< cells and parts of cells; `failed` also counts references
};

/// Returns DIR/finished.json, which exists when all work of a run is done or has failed.
std::string finished_file(const std::string& directory);
/// Returns whether a file in a results directory is a mark.
bool is_run_mark(const std::string& name);

/// Makes the directory, marks the beginning of a run of this shard, and removes marks of an earlier run.
Status mark_begun(const std::string& directory, const RunMark& mark);
Status mark_finished(const std::string& directory, const RunMark& mark);
/// Marks an error, if the disk has space. The message is also printed.
void mark_error(const std::string& directory, const Error& error);

/// Returns the mark of the beginning; nothing if it is missing or unreadable.
std::optional<RunMark> begun_mark(const std::string& directory);
std::optional<RunMark> finished_mark(const std::string& directory);
/// Returns whether the run finished without failed cells.
bool is_done(const std::string& directory);
/// Returns the error that ended the last run; empty if there is none.
std::string error_mark(const std::string& directory);

}  // namespace raylex::experiments
