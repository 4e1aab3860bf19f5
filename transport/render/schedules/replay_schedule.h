// One sample of one pixel, with the bits that it has in the whole image.
#pragma once

#include "transport/render/schedule.h"

namespace raylex::transport {

class ReplaySchedule final : public Schedule {
  public:
    explicit ReplaySchedule(const ResolvedJob& job) : grid_(job.grid), budget_(job.budget) {}

    [[nodiscard]] bool finished(const RenderPosition& position) const override { return position.phase > 0; }
    std::uint64_t begin_phase(RenderPosition& /*position*/) override { return 1; }
    void render(std::uint64_t task, RenderWorker& worker) const override;
    [[nodiscard]] bool can_save_amid_phase() const override { return false; }
    [[nodiscard]] display::Forecast expected_samples(std::uint64_t /*done*/,
                                                     const RenderState& /*state*/) const override {
        return {1, 0};
    }
    [[nodiscard]] std::uint64_t samples_per_pixel() const override { return budget_.samples_per_pixel; }

  private:
    const TileGrid& grid_;
    const Budget& budget_;
};

}  // namespace raylex::transport
