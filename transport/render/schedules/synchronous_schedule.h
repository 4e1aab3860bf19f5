// One phase for each block of samples of the image: an iteration of a synchronous integrator, or the work of a sink
// between two checks of its memory. Threads synchronise after it.
#pragma once

#include "transport/render/schedules/plain_schedule.h"

namespace raylex::transport {

class SynchronousSchedule final : public PlainSchedule {
  public:
    explicit SynchronousSchedule(const ResolvedJob& job) : PlainSchedule(job) {}

    [[nodiscard]] RenderPosition beginning() const override;
    [[nodiscard]] bool finished(const RenderPosition& position) const override {
        return position.phase >= TileGrid::blocks_for(budget_.samples_per_pixel);
    }
    /// Phases are ranges of one numbering of tasks.
    std::uint64_t begin_phase(RenderPosition& position) override;
    /// False: the integrator's gathered data are incomplete before its threads synchronise.
    [[nodiscard]] bool can_save_amid_phase() const override { return false; }
};

}  // namespace raylex::transport
