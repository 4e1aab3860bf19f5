// How far a study over many processes is, from what they leave on disk and from what a queue says of them.
#pragma once

#include <string>
#include <vector>

#include "lpe/result.h"

namespace raylex::experiments {

enum class TaskState { done, running, queued, failed, stopped, missing };

struct TaskStatus {
    std::string name;  ///< "references", "shard 2", "merge"
    TaskState state = TaskState::missing;
    std::size_t cells = 0, failed_cells = 0;  ///< of a shard, so far
    std::string message;                      ///< what failed
};

struct StudyStatus {
    std::vector<TaskStatus> tasks;
    std::string warning;  ///< a queue that does not answer
    [[nodiscard]] std::size_t count(TaskState state) const;
};

/// Of the directory that was given to `submit`, or to `experiment plan --commands`. Errors: nothing was begun there.
Result<StudyStatus> study_status(const std::string& directory);

std::string state_text(TaskState state);

}  // namespace raylex::experiments
