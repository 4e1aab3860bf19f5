#include "transport/render/schedules/adaptive_schedule.h"

#include <algorithm>
#include <array>

#include "transport/render/stages/render_state.h"

namespace raylex::transport {

std::uint64_t AdaptiveSchedule::begin_phase(RenderPosition& /*position*/) {
    open_tiles_.clear();
    for (std::uint64_t tile = 0; tile < grid_.count(); ++tile) {
        bool open = false;
        grid_.for_each_pixel(tile, [&](int x, int y) { open = open || sampler_.open(x, y); });
        if (open) open_tiles_.push_back(static_cast<std::uint32_t>(tile));
    }
    return open_tiles_.size();
}

/// Adds the next blocks of each open pixel of the tile. No other thread adds to these pixels meanwhile.
void AdaptiveSchedule::render(std::uint64_t task, RenderWorker& worker) const {
    constexpr std::uint64_t size = TileGrid::block_size;
    struct OpenPixel {
        int x, y;
        std::uint64_t first;
    };
    std::array<OpenPixel, TileGrid::tile_size * TileGrid::tile_size> pixels;
    std::size_t open = 0;
    worker.begin_tile(open_tiles_[task]);
    grid_.for_each_pixel(open_tiles_[task], [&](int x, int y) {
        if (sampler_.open(x, y)) pixels[open++] = {x, y, frame_buffer_.sample_count(x, y)};
    });
    // The blocks of a stopped task in the frame buffer are not those at its beginning.
    const std::uint64_t skipped = worker.blocks_skipped();
    for (std::size_t i = 0; i < open; ++i)
        pixels[i].first -= std::min(pixels[i].first, (skipped / open + (i < skipped % open ? 1 : 0)) * size);
    for (std::uint64_t block = 0; block < sampler_.blocks(); ++block)
        for (std::size_t i = 0; i < open; ++i) {
            const std::uint64_t first = pixels[i].first + block * size;
            if (first >= sampler_.max_samples()) continue;
            const auto count = static_cast<int>(std::min(size, sampler_.max_samples() - first));
            worker.add_pixel(pixels[i].x, pixels[i].y, first, count, block * open + i);
        }
}

void AdaptiveSchedule::end_phase(RenderState& state) {
    sampler_.decide(frame_buffer_);
    Schedule::end_phase(state);
}

display::Forecast AdaptiveSchedule::expected_samples(std::uint64_t done, const RenderState& /*state*/) const {
    const display::AdaptiveProgress& progress = sampler_.progress();
    return {static_cast<double>(std::max(progress.predicted_samples, done)),
            static_cast<double>(progress.least_samples)};
}

}  // namespace raylex::transport
