// Checks the types and parameters in a job against the declarations of its integrator, sampler and filter.
#pragma once

#include "experiments/job/job.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// Checks the types that the job names by file or flag, and their parameters. The first unknown one is an Error at its
/// place that lists the known ones, with the closest match. This includes names of pbrt that raylex lacks: a job gets
/// the named object or an error. Names in a scene file are checked by the import and the render, which may replace
/// pbrt's types with a warning.
Status check_parameters(const Job& job);

}  // namespace raylex::experiments
