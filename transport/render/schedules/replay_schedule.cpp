#include "transport/render/schedules/replay_schedule.h"

#include "transport/render/stages/render_worker.h"

namespace raylex::transport {

void ReplaySchedule::render(std::uint64_t /*task*/, RenderWorker& worker) const {
    const SampleChoice& only = *budget_.only;
    worker.begin_tile(grid_.tile_of(only.x, only.y));
    worker.add_pixel(only.x, only.y, only.sample, 1, 0);
}

}  // namespace raylex::transport
