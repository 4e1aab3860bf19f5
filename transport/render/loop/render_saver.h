// When a render is saved, and the saving. Private to transport/render.
#pragma once

#include <memory>

#include "transport/render/stages/checkpoint.h"
#include "transport/render/stages/render_state.h"

namespace raylex::transport {

/// Without CheckpointSettings nothing is ever due.
class RenderSaver {
  public:
    /// What may go wrong is found before the first ray: an Error names what cannot be saved.
    static Result<RenderSaver> make(const RenderState& state);

    /// Goes on from the file when the settings say so; else where the state's schedule begins, after what `earlier`
    /// tells.
    Status set_out(RenderState& state, const RenderStatistics& earlier) const;
    [[nodiscard]] bool enabled() const { return settings_ != nullptr; }
    [[nodiscard]] bool due(const RenderState& state) const;
    /// How long threads may go on without anybody asking whether a record is due.
    [[nodiscard]] double interval() const { return settings_ ? std::min(0.2, settings_->seconds) : 0.2; }
    /// As save(), of a bucket that is finished: what goes wrong is an Error, since there will be nothing else of it.
    Status keep(const RenderState& state);
    /// While threads stand still. What goes wrong is no reason to give up the render.
    void save(const RenderState& state);
    /// After the last save(): puts on disk what is on its way, and tells of it.
    void finish(RenderStatistics& statistics, std::vector<Error>& warnings);

  private:
    RenderSaver() = default;
    const CheckpointSettings* settings_ = nullptr;
    display::RecordIdentity identity_;
    std::unique_ptr<CheckpointWriter> writer_;
    double last_ = 0, stall_ = 0;  // seconds of the session
};

}  // namespace raylex::transport
