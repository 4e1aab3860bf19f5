// One render from a job to files on disk.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "experiments/job/job.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// What all samples of a job would take.
struct RenderEstimate {
    std::uint64_t samples_per_pixel = 0;
    std::uint64_t memory_bytes = 0;  ///< resident at most, about, of a process that renders any number of them
    double cpu_seconds = -1;         ///< of all threads; negative: not known
};

/// Loads, proves, and, if `calibrate`, renders for two seconds; writes nothing. The exit code to end with when that
/// cannot be done, or when the job cannot be rendered in shards.
std::optional<int> estimate_render(Job job, const std::vector<std::string>& arguments, bool calibrate,
                                   RenderEstimate& estimate);

/// Loads, proves, renders, writes, checks the file written, and says what it did. Returns the exit code.
int run_render(Job job, const std::vector<std::string>& arguments);

}  // namespace raylex::experiments
