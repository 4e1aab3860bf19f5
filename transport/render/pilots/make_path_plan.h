// The plan of a render's camera subpaths (paths/plan/path_plan.h), made once from pilots before the integrator
// prepares.
#pragma once

#include "transport/integrators/integrator.h"

namespace raylex::transport {

struct PlannedPaths {
    PathPlan plan;
    std::uint64_t rays = 0;  ///< number of rays that pilots traced; none contributes to the image
};

/// Plans what `request` allows, for renders without beauty, where channels alone decide which rays are traced (Law 4).
/// With beauty the plan changes nothing.
PlannedPaths make_path_plan(const IntegratorContext& context, const PlanRequest& request);

}  // namespace raylex::transport
