// What camera rays see, for integrators that do not report it (IntegratorTraits::first_hits): distance, opacity,
// surface, rows of media, geometric AOVs and what patterns write to channels at first hits. Private to
// transport/render.
#pragma once

#include <memory>

#include "transport/render/stages/prepared_job.h"

namespace raylex::transport {

/// One thread's. It follows the camera rays of a batch once more, as `path` does, with the same random numbers.
class CameraHits {
  public:
    /// The job must outlive this object.
    explicit CameraHits(const PreparedJob& prepared);

    /// Fills in the rows of `table` to which the integrator reported nothing, and the plain channels of the rows to
    /// which nothing was sent.
    void supply(const CameraBatch& batch, display::SampleTable& table);

  private:
    const display::LpeSetup no_channels_;  // light that the rays meet goes to no channel
    const EventTable events_;
    std::unique_ptr<Integrator> path_;
    std::unique_ptr<IntegratorThread> thread_;
    display::SampleTable seen_;
    display::DisplayServices display_;
    display::LpeServices lpe_;
};

}  // namespace raylex::transport
