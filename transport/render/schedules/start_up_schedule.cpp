#include "transport/render/schedules/start_up_schedule.h"

#include "transport/render/stages/render_worker.h"

namespace raylex::transport {

void StartUpSchedule::render(std::uint64_t task, RenderWorker& worker) const {
    worker.start_up(task);
}

}  // namespace raylex::transport
