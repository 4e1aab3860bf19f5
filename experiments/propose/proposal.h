// Proposes passes by measurement: pilots give the noise and the cost of each method, by classes of paths.
#pragma once

#include <cstdint>
#include <string>

#include "experiments/job/job.h"
#include "experiments/job/rendering/job_scene.h"
#include "experiments/propose/pilot.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// Returns [[pass]] tables for a job without integrator and passes, with the forecast as comments: the passes that
/// minimise the forecast product of squared error and CPU time. One pass alone is the best single method, if no passes
/// beat it. The passes take the CPU time of `samples` samples per pixel of the best single method. Prints a note before
/// each pilot. Errors: no method supports the scene.
Result<std::string> propose_passes(const Job& job, const JobScene& scene, const transport::BuiltScene& built,
                                   std::uint64_t samples, const PilotSettings& settings);

}  // namespace raylex::experiments
