// Hits of camera rays, for integrators that do not report them (IntegratorTraits::first_hits): distance, opacity,
// surface, rows of media, geometric AOVs and the channels that patterns write at first hits. Private to
// transport/render.
#pragma once

#include <memory>

#include "transport/render/stages/prepared_job.h"

namespace raylex::transport {

/// One per thread. It traces the camera rays of a batch again, as `path` does, with the same random numbers.
class CameraHits {
  public:
    /// `prepared` must outlive this object.
    explicit CameraHits(const PreparedJob& prepared);

    /// Fills in the rows of `table` for which the integrator reported nothing, and the plain channels of rows without
    /// values.
    void supply(const CameraBatch& batch, display::SampleTable& table);

  private:
    const display::LpeSetup no_channels_;  // light along the rays is written to no channel
    const EventTable events_;
    std::unique_ptr<Integrator> path_;
    std::unique_ptr<IntegratorThread> thread_;
    display::SampleTable seen_;
    display::DisplayServices display_;
    display::LpeServices lpe_;
};

}  // namespace raylex::transport
