#include "transport/render/pilots/guide_viewer.h"

#include <algorithm>
#include <stdexcept>

#include "transport/paths/plan/path_plan.h"
#include "transport/render/pilots/pilot_paths.h"

namespace raylex::transport {

std::shared_ptr<const GuideView> view_guide(const IntegratorContext& context, const GuideRequest& request,
                                            const Guide& guide, const std::atomic<bool>* stop) {
    constexpr std::uint64_t most_points = 16'384;
    const geoaovs::GeometricAovs no_aovs{std::span<const display::ChannelDefinition>()};
    IntegratorContext trial = context;
    trial.first_hits.aovs = &no_aovs;
    trial.first_hits.pattern_channels = false;
    // No roulette ends these paths before the vertex that is looked for. Closures draw their directions.
    PathPlan plan;
    plan.follows_whole_paths = true;
    plan.most_depth = PilotPaths::most_depth;
    trial.plan = &plan;
    trial.directions = nullptr;
    const auto integrator = request.make_trial();
    if (const Status status = integrator->prepare(trial); !status) throw std::runtime_error(status.error().message);
    const auto thread = integrator->make_thread_state();

    auto view = std::make_shared<GuideView>(GuideView{.tree = guide.tree()});
    const auto points = [&](int pixels) { return (static_cast<std::uint32_t>(pixels) + view->step - 1) / view->step; };
    while (std::uint64_t{points(trial.view.width)} * points(trial.view.height) > most_points) ++view->step;
    view->width = points(trial.view.width);
    view->height = points(trial.view.height);
    view->regions.assign(std::size_t{view->width} * view->height, GuideView::no_region);
    for (std::size_t i = 0; i < 9; ++i) view->to_camera[i] = trial.first_hits.world_to_camera[i / 3][i % 3];

    PilotPaths paths(trial);
    if (stop != nullptr) paths.leave_when(*stop);
    paths.begin_pixels({0, 0, trial.view.width, trial.view.height}, ~trial.services.seed, 0, 1,
                       static_cast<int>(view->step));
    paths.follow(*integrator, *thread, [&](std::size_t point, const LaterRadiance::Path& path) {
        const auto first = std::find_if(path.vertices.begin(), path.vertices.end(),
                                        [](const PassedVertex& v) { return v.guidable || !v.specular; });
        if (first != path.vertices.end() && first->guidable)
            view->regions[point] = view->tree.place_of(first->position, first->normal).region;
    });
    return view;
}

}  // namespace raylex::transport
