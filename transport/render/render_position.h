// Where a render stands, as checkpoints remember it.
#pragma once

#include <cstdint>
#include <vector>

#include "transport/render/render.h"

namespace raylex::transport {

/// A task that its thread had to leave.
struct UnfinishedTask {
    std::uint64_t task = 0;
    std::uint64_t done =
        0;  ///< of the blocks of pixels that it goes through, so many first ones are in the frame buffer
};

struct RenderPosition {
    std::uint64_t phase = 0;                 ///< a run of tasks that threads go through without meeting
    std::uint64_t task = 0;                  ///< the first task of the phase that no thread has taken
    std::vector<UnfinishedTask> unfinished;  ///< before `task`: all others there are in the frame buffer, whole
    RenderStatistics statistics;             ///< of what is in the frame buffer, by earlier sessions
};

}  // namespace raylex::transport
