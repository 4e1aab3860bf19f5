// A render that ends by time or error. A phase is a pass over the whole image (limited_passes.h), so that all pixels
// have the same number of samples. A pass that cannot end in time is undone; if there was no pass before it, the render
// is incomplete.
#pragma once

#include "display/checkpoint/record_file.h"
#include "transport/render/resolve/limited_passes.h"
#include "transport/render/schedule.h"

namespace raylex::transport {

class LimitedSchedule final : public Schedule {
  public:
    LimitedSchedule(const ResolvedJob& job, const display::FrameBuffer& frame_buffer);

    [[nodiscard]] RenderPosition beginning() const override;
    void begin_session(const RenderState& state) override { choose_pass(state); }
    [[nodiscard]] bool finished(const RenderPosition& /*position*/) const override { return reached_; }
    std::uint64_t begin_phase(RenderPosition& position) override;
    void render(std::uint64_t task, RenderWorker& worker) const override;
    void end_phase(RenderState& state) override;

    /// False: the length of the next pass depends on the clock.
    [[nodiscard]] bool can_save_amid_phase() const override { return false; }
    [[nodiscard]] bool overdue(const RenderState& state) const override;
    /// Discards the samples of a pass that cannot end in time, so that all pixels have the same number, and a render of
    /// that number gives the same bits. A first pass is started again with fewer samples if there is time. If even one
    /// sample per pixel takes too long, there is no complete pass to return to: the partial image stays, as after a
    /// stop.
    Status after_overdue(RenderState& state) override;

    [[nodiscard]] display::Forecast expected_samples(std::uint64_t done, const RenderState& state) const override;
    [[nodiscard]] const display::AdaptiveProgress* error() const override { return passes_.error(); }
    [[nodiscard]] std::uint64_t samples_per_pixel() const override { return pass_chosen_ ? end_ : most_; }

  private:
    void choose_pass(const RenderState& state);
    [[nodiscard]] double time_left(const RenderState& state) const;  ///< infinite without a limit of time
    [[nodiscard]] double share_done(const RenderState& state) const;
    [[nodiscard]] bool pass_is_too_long(const RenderState& state) const;

    const TileGrid& grid_;
    const std::uint64_t tiles_, first_sample_, most_;
    const SampleLimit limit_;
    const bool synchronous_;
    LimitedPasses passes_;
    std::uint64_t begin_ = 0, end_ = 0;  // samples per pixel before and after the pass
    bool pass_chosen_ = false;           // in this session
    bool reached_ = false;
    bool first_pass_ = false;                    // of a session: the time of a sample is unknown
    std::optional<display::RecordFile> before_;  // the whole render before the pass, if the time may end within it
    double begin_seconds_ = 0;
    std::uint64_t begin_samples_ = 0;  // camera samples of all pixels
};

}  // namespace raylex::transport
