// Adds samples where the error is above a tolerance. A phase contains the samples of one decision of the adaptive
// sampler; a task is some blocks of the open pixels of a tile.
#pragma once

#include "transport/render/schedule.h"

namespace raylex::transport {

class AdaptiveSchedule final : public Schedule {
  public:
    AdaptiveSchedule(const ResolvedJob& job, const display::FrameBuffer& frame_buffer)
        : grid_(job.grid),
          frame_buffer_(frame_buffer),
          sampler_(*job.budget.adaptive, job.channels.list, job.channels.beauty, frame_buffer.layout()) {}

    [[nodiscard]] bool finished(const RenderPosition& /*position*/) const override { return sampler_.done(); }
    std::uint64_t begin_phase(RenderPosition& position) override;
    void render(std::uint64_t task, RenderWorker& worker) const override;
    void end_phase(RenderState& state) override;

    [[nodiscard]] display::Forecast expected_samples(std::uint64_t done, const RenderState& state) const override;
    [[nodiscard]] const display::AdaptiveProgress* error() const override { return &sampler_.progress(); }
    [[nodiscard]] std::uint64_t unconverged() const override { return sampler_.unconverged(); }
    [[nodiscard]] std::uint64_t samples_per_pixel() const override { return sampler_.max_samples(); }

    [[nodiscard]] std::string section() const override { return "adaptive"; }
    void append_record(std::string& bytes) const override { sampler_.append_record(bytes); }
    Status restore_record(std::string_view bytes) override { return sampler_.restore_record(bytes); }

  private:
    const TileGrid& grid_;
    const display::FrameBuffer& frame_buffer_;
    display::AdaptiveSampler sampler_;
    std::vector<std::uint32_t> open_tiles_;  // of this phase
};

}  // namespace raylex::transport
