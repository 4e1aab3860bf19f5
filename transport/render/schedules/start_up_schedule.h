// The start-up of an integrator before the image (Integrator::starts_up): one call for each tile, in one phase.
#pragma once

#include "transport/render/schedule.h"

namespace raylex::transport {

/// Time and progress are those of the schedule that follows.
class StartUpSchedule final : public Schedule {
  public:
    StartUpSchedule(const TileGrid& grid, const Schedule& then) : tiles_(grid.count()), then_(then) {}

    [[nodiscard]] bool finished(const RenderPosition& position) const override { return position.phase > 0; }
    std::uint64_t begin_phase(RenderPosition& /*position*/) override { return tiles_; }
    void render(std::uint64_t task, RenderWorker& worker) const override;
    [[nodiscard]] bool can_save_amid_phase() const override { return false; }
    [[nodiscard]] bool overdue(const RenderState& state) const override { return then_.overdue(state); }
    [[nodiscard]] display::Forecast expected_samples(std::uint64_t done, const RenderState& state) const override {
        return then_.expected_samples(done, state);
    }
    [[nodiscard]] const display::AdaptiveProgress* error() const override { return then_.error(); }
    [[nodiscard]] std::uint64_t samples_per_pixel() const override { return then_.samples_per_pixel(); }

  private:
    const std::uint64_t tiles_;
    const Schedule& then_;
};

}  // namespace raylex::transport
