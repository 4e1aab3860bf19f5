// The second stage: the integrator has seen the scene, and the job does not change any more. Private to
// transport/render.
#pragma once

#include <memory>

#include "transport/render/pilots/make_path_plan.h"
#include "transport/render/resolve/resolved_job.h"

namespace raylex::transport {

class PreparedJob {
  public:
    /// Events, geometric AOVs, Integrator::prepare() with all of them; an Error is the integrator's.
    static Result<PreparedJob> prepare(ResolvedJob resolved);

    /// What an integrator sees of the render. The pointers are to what stays where it is when the job is moved.
    [[nodiscard]] IntegratorContext context() const;

    ResolvedJob job;
    std::unique_ptr<const EventTable> events;
    std::unique_ptr<const geoaovs::GeometricAovs> aovs;
    std::unique_ptr<const PlannedPaths> paths;
    double seconds = 0, cpu_seconds = 0;  ///< that it took

  private:
    explicit PreparedJob(ResolvedJob resolved) : job(std::move(resolved)) {}
};

}  // namespace raylex::transport
