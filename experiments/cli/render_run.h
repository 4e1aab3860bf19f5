// One render from a job to files on disk.
#pragma once

#include <string>
#include <vector>

#include "experiments/job/job.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// Loads, proves, renders, writes, checks the file written, and says what it did. Returns the exit code.
int run_render(Job job, const std::vector<std::string>& arguments);

}  // namespace raylex::experiments
