// A job's types and parameters against what the integrator, sampler and filter it names declare.
#pragma once

#include "experiments/job/job.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// The types that the job names by file or flag, and their parameters: the first that is not there is an Error at its
/// place that lists what there is, with the near miss. Names of pbrt that raylex lacks are no exception: who asks for
/// one by name gets it or an error. A scene file's are judged by the import and the render, which know what pbrt reads
/// there and what may take its place, with a warning.
Status check_parameters(const Job& job);

}  // namespace raylex::experiments
