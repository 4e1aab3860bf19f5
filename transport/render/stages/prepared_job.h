// The second stage: the integrator has prepared for the scene, and the job no longer changes. Private to
// transport/render.
#pragma once

#include <atomic>
#include <memory>

#include "transport/render/clock.h"
#include "transport/render/pilots/guide_pilot.h"
#include "transport/render/pilots/make_path_plan.h"
#include "transport/render/resolve/resolved_job.h"
#include "transport/render/stages/guide_file.h"

namespace raylex::transport {

class PreparedJob {
  public:
    /// Prepares events and geometric AOVs and calls Integrator::prepare() with them; Errors are the integrator's.
    /// `since_call` measures the time since the call of render(). `*stop` (may be null) ends the training of a guide.
    static Result<PreparedJob> prepare(ResolvedJob resolved, const Stopwatch& since_call = {},
                                       const std::atomic<bool>* stop = nullptr);

    /// The integrator's view of the render. Its pointers stay valid when the job is moved.
    [[nodiscard]] IntegratorContext context() const;

    ResolvedJob job;
    std::unique_ptr<const EventTable> events;
    std::unique_ptr<const geoaovs::GeometricAovs> aovs;
    std::unique_ptr<const PlannedPaths> paths;
    TrainedGuide guide;
    GuideFile unwritten;  ///< gets the guide of a checkpoint when restore_checkpoint() has checked whose it is
    std::shared_ptr<const GuideView> guide_view;  ///< RenderStatistics::guide_view
    double seconds = 0, cpu_seconds = 0;          ///< of the preparation

  private:
    [[nodiscard]] GuideTraining training() const;
    Status train(GuideTraining training, GuideFile file, const Stopwatch& since_call, const std::atomic<bool>* stop);
    explicit PreparedJob(ResolvedJob resolved) : job(std::move(resolved)) {}
};

}  // namespace raylex::transport
