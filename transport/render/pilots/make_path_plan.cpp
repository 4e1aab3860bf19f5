#include "transport/render/pilots/make_path_plan.h"

#include "transport/render/pilots/last_vertex.h"
#include "transport/render/pilots/roulette_pilot.h"
#include "transport/render/pilots/split_pilot.h"

namespace raylex::transport {

PlannedPaths make_path_plan(const IntegratorContext& context, const PlanRequest& request) {
    PlannedPaths planned;
    const EventTable& events = *context.events;
    if (!request.make_trial || context.beauty || !events.prunes() || !events.any() ||
        !events.liveness().at_camera().scatters)
        return planned;
    PathPlan& plan = planned.plan;
    // Built once, for the pilots and for the render.
    plan.lights =
        std::make_shared<const LiveLights>(context.scene, events, request.light_choice, request.lights_by_receiver);
    const LiveLights& lights = *plan.lights;
    const bool may_end_rays = request.roulette_below > 0;
    if (may_end_rays && !lights[LiveLights::all].empty())
        plan.shares = choose_techniques(context, lights, planned.rays);
    const PathTrials trials(context, request, plan);
    SplitChoice splits;
    if (request.splits) splits = choose_splits(context, trials, planned.rays);
    if (request.roulette && may_end_rays)
        plan.roulette = choose_roulette(context, trials, splits, request.roulette_below, planned.rays);
    plan.splits = splits.plan;
    return planned;
}

}  // namespace raylex::transport
