// Which samples a render takes, in which order: one interface, one small class for each way (schedules/).
//
// A task is a number; what stands behind it, a schedule alone knows: some blocks of samples (16, aligned) of the pixels
// of one tile (16 x 16). Threads take the next number, so an interrupted render has an even image, and which thread
// took which task cannot be seen in the result: samples are counter-based and the frame buffer adds exactly. A phase is
// a run of tasks that the threads go through without meeting. Between phases nothing is in flight, and the schedule
// decides on the next one.
//
// Calls to a schedule are one a task at most. Private to transport/render.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "display/buffer/adaptive/adaptive_sampler.h"
#include "transport/render/render_position.h"
#include "transport/render/stages/render_target.h"

namespace raylex::transport {

class RenderState;
class RenderWorker;

class Schedule {
  public:
    virtual ~Schedule() = default;

    /// Where a render stands that resumes nothing.
    [[nodiscard]] virtual RenderPosition beginning() const { return {}; }
    /// Once a session, before its first phase; not when the render has to end before that.
    virtual void begin_session(const RenderState& /*state*/) {}
    /// Between phases: whether all that was asked for is there.
    [[nodiscard]] virtual bool finished(const RenderPosition& position) const = 0;
    /// Sets the position to the phase's first task, unless it stands amid the phase. Returns the end of its tasks.
    virtual std::uint64_t begin_phase(RenderPosition& position) = 0;
    /// Has the worker add the samples of a task; by many threads at once.
    virtual void render(std::uint64_t task, RenderWorker& worker) const = 0;
    /// All of the phase's tasks are in the frame buffer: moves the position on to the next phase.
    virtual void end_phase(RenderState& state);

    /// Whether a record taken between two tasks of a phase is whole.
    [[nodiscard]] virtual bool can_save_amid_phase() const { return true; }
    /// While threads work: whether they must leave their batches, because the phase takes too long.
    [[nodiscard]] virtual bool overdue(const RenderState& /*state*/) const { return false; }
    /// After threads had to leave their batches for that: what to make of the phase.
    virtual Status after_overdue(RenderState& /*state*/) { return success(); }

    /// Camera samples that the whole render will have taken; `done` are there.
    [[nodiscard]] virtual display::Forecast expected_samples(std::uint64_t done, const RenderState& state) const = 0;
    /// Null when the schedule does not measure it.
    [[nodiscard]] virtual const display::AdaptiveProgress* error() const { return nullptr; }
    /// Pixels that have all the samples they may have and are not good enough.
    [[nodiscard]] virtual std::uint64_t unconverged() const { return 0; }
    /// The budget, or what the render came to.
    [[nodiscard]] virtual std::uint64_t samples_per_pixel() const = 0;

    /// The section of a checkpoint with what the frame buffer does not tell; empty: nothing.
    [[nodiscard]] virtual std::string section() const { return {}; }
    virtual void append_record(std::string& /*bytes*/) const {}
    virtual Status restore_record(std::string_view /*bytes*/) { return success(); }
};

/// The schedule of the job's budget. Both must outlive it.
std::unique_ptr<Schedule> make_schedule(const PreparedJob& prepared, const RenderTarget& target);

}  // namespace raylex::transport
