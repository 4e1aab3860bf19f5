// The progress of a study over many processes, from its files on disk and from a queue.
#pragma once

#include <string>
#include <vector>

#include "lpe/result.h"

namespace raylex::experiments {

enum class TaskState { done, running, queued, failed, stopped, missing };

struct TaskStatus {
    std::string name;  ///< "references", "shard 2", "merge"
    TaskState state = TaskState::missing;
    std::size_t runs = 0, failed_runs = 0;  ///< of a shard, so far
    std::string message;                    ///< error message
};

struct StudyStatus {
    std::vector<TaskStatus> tasks;
    std::string warning;  ///< the queue does not answer
    [[nodiscard]] std::size_t count(TaskState state) const;
};

/// Returns the status of the study in the directory of `submit`, or of `experiment plan --commands`. Errors: the
/// directory contains no study.
Result<StudyStatus> study_status(const std::string& directory);

std::string state_text(TaskState state);

}  // namespace raylex::experiments
