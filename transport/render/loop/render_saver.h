// Decides when a render is saved, and saves it. Private to transport/render.
#pragma once

#include <memory>

#include "transport/render/stages/checkpoint.h"
#include "transport/render/stages/render_state.h"

namespace raylex::transport {

/// Saves a render at intervals; without CheckpointSettings it never saves.
class RenderSaver {
  public:
    /// Checks before the first ray that the render can be saved. Errors name what cannot.
    static Result<RenderSaver> make(const RenderState& state);

    /// Sets the state to the checkpoint file if the settings request it. Otherwise sets it to the schedule's beginning,
    /// with the statistics of `earlier`.
    Status start(RenderState& state, const RenderStatistics& earlier) const;
    [[nodiscard]] bool enabled() const { return settings_ != nullptr; }
    [[nodiscard]] bool due(const RenderState& state) const;
    /// The longest time in seconds that threads may run without a check whether a save is due.
    [[nodiscard]] double interval() const { return settings_ ? std::min(0.2, settings_->seconds) : 0.2; }
    /// Saves a finished bucket. Failures are Errors, since the bucket's memory is released next.
    Status keep(const RenderState& state);
    /// Saves while threads are stopped. Failures do not end the render.
    void save(const RenderState& state);
    /// Finishes pending writes after the last save(), and reports them.
    void finish(RenderStatistics& statistics, std::vector<Error>& warnings);

  private:
    RenderSaver() = default;
    const CheckpointSettings* settings_ = nullptr;
    display::RecordIdentity identity_;
    std::unique_ptr<CheckpointWriter> writer_;
    double last_ = 0, stall_ = 0;  // seconds since the beginning of the session
};

}  // namespace raylex::transport
