#include "transport/render/schedules/plain_schedule.h"

#include <algorithm>

#include "transport/render/stages/render_worker.h"

namespace raylex::transport {

void render_block(std::uint64_t task, const TileGrid& grid, std::uint64_t end, RenderWorker& worker) {
    const std::uint64_t tiles = grid.region_count(), first = task / tiles * TileGrid::block_size;
    worker.add_tile(grid.region_tile(task % tiles), first,
                    static_cast<int>(std::min<std::uint64_t>(TileGrid::block_size, end - first)));
}

RenderPosition PlainSchedule::beginning() const {
    RenderPosition position;
    position.task = budget_.first_sample / TileGrid::block_size * tiles_;
    return position;
}

std::uint64_t PlainSchedule::begin_phase(RenderPosition& /*position*/) {
    return TileGrid::blocks_for(budget_.samples_per_pixel) * tiles_;
}

void PlainSchedule::render(std::uint64_t task, RenderWorker& worker) const {
    render_block(task, grid_, budget_.samples_per_pixel, worker);
}

display::Forecast PlainSchedule::expected_samples(std::uint64_t /*done*/, const RenderState& /*state*/) const {
    // Splatting takes samples from around the image too.
    const std::uint64_t pixels =
        static_cast<std::uint64_t>(grid_.region.width()) * static_cast<std::uint64_t>(grid_.region.height());
    return {static_cast<double>(pixels * (budget_.samples_per_pixel - budget_.first_sample)), 0};
}

}  // namespace raylex::transport
