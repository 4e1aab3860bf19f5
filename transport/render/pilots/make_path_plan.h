// The plan of a render's camera subpaths (paths/plan/path_plan.h), made once from pilots before the integrator
// prepares.
#pragma once

#include "transport/integrators/integrator.h"

namespace raylex::transport {

struct PlannedPaths {
    PathPlan plan;
    std::uint64_t rays = 0;  ///< that pilots traced; none of them is of the image
};

/// Plans what `request` allows, where channels alone decide which rays are traced (Law 4): without beauty. Else the
/// plan changes nothing.
PlannedPaths make_path_plan(const IntegratorContext& context, const PlanRequest& request);

}  // namespace raylex::transport
