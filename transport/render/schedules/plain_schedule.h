// A fixed number of samples of every pixel, in one phase: block by block, each over the whole image.
#pragma once

#include "transport/render/schedule.h"

namespace raylex::transport {

/// A plain schedule; a shard does not begin with sample 0.
class PlainSchedule : public Schedule {
  public:
    explicit PlainSchedule(const ResolvedJob& job)
        : grid_(job.grid), tiles_(job.grid.region_count()), budget_(job.budget) {}

    [[nodiscard]] RenderPosition beginning() const override;
    [[nodiscard]] bool finished(const RenderPosition& position) const override { return position.phase > 0; }
    std::uint64_t begin_phase(RenderPosition& position) override;
    void render(std::uint64_t task, RenderWorker& worker) const override;
    [[nodiscard]] display::Forecast expected_samples(std::uint64_t done, const RenderState& state) const override;
    [[nodiscard]] std::uint64_t samples_per_pixel() const override { return budget_.samples_per_pixel; }

  protected:
    const TileGrid& grid_;
    const std::uint64_t tiles_;
    const Budget& budget_;
};

/// Makes the worker add the block of a tile that `task` stands for, with tasks numbered block by block over the tiles
/// of the region; adds no samples at or beyond sample `end`.
void render_block(std::uint64_t task, const TileGrid& grid, std::uint64_t end, RenderWorker& worker);

}  // namespace raylex::transport
