#include "transport/render/schedules/synchronous_schedule.h"

namespace raylex::transport {

RenderPosition SynchronousSchedule::beginning() const {
    RenderPosition position = PlainSchedule::beginning();
    position.phase = budget_.first_sample / TileGrid::block_size;
    return position;
}

std::uint64_t SynchronousSchedule::begin_phase(RenderPosition& position) {
    position.task = position.phase * tiles_;
    return position.task + tiles_;
}

}  // namespace raylex::transport
