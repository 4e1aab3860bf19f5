// Runs one render, from a job to files on disk.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "experiments/job/job.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// Estimated cost of all samples of a job.
struct RenderEstimate {
    std::uint64_t samples_per_pixel = 0;
    std::uint64_t memory_bytes = 0;  ///< approximate peak resident memory of a process, for any number of samples
    double cpu_seconds = -1;         ///< of all threads together; negative: unknown
};

/// Loads the scene and proves the partitions. If `calibrate`, also renders for two seconds. Writes no file. Returns an
/// exit code if that fails or if the job cannot be rendered in shards; otherwise nothing, and fills `estimate`.
std::optional<int> estimate_render(Job job, const std::vector<std::string>& arguments, bool calibrate,
                                   RenderEstimate& estimate);

/// Loads, proves, renders, writes, checks the written file, and prints a summary. Returns the exit code.
int run_render(Job job, const std::vector<std::string>& arguments);

}  // namespace raylex::experiments
