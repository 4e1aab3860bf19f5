// A job's parameters against what the integrator, sampler and filter it names declare.
#pragma once

#include "experiments/job/job.h"
#include "lpe/result.h"

namespace raylex::experiments {

/// The first parameter of the job file's [integrator], [sampler] or [filter] that the named type does not declare, as
/// an Error at its place that lists what there is. A scene file's parameters were judged by the import, which knows
/// what pbrt reads there. Types that are not registered are left to the render, which knows their fallbacks.
Status check_parameters(const Job& job);

}  // namespace raylex::experiments
