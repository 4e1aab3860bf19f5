// The position of a render, as checkpoints store it.
#pragma once

#include <cstdint>
#include <vector>

#include "transport/render/render.h"

namespace raylex::transport {

/// A task that its thread had to stop early.
struct UnfinishedTask {
    std::uint64_t task = 0;
    std::uint64_t done = 0;  ///< number of its first blocks of pixels that are in the frame buffer
};

struct RenderPosition {
    std::uint64_t phase = 0;  ///< a run of tasks without synchronisation of threads
    std::uint64_t task = 0;   ///< the first task of the phase that no thread has started
    /// tasks before `task` that are not complete; all others are in the frame buffer
    std::vector<UnfinishedTask> unfinished;
    RenderStatistics statistics;  ///< of the samples in the frame buffer from earlier sessions
};

}  // namespace raylex::transport
