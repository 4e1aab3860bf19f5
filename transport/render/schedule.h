// The samples of a render and their order: one interface, with one small class for each kind of schedule (schedules/).
//
// A task is a number, whose meaning is private to the schedule: some blocks of samples (16, aligned) of the pixels of
// one tile (16 x 16). Threads take the next number, so an interrupted render has an even image. The assignment of tasks
// to threads does not affect the result: samples are counter-based and the frame buffer adds exactly. A phase is a run
// of tasks without synchronisation of threads. Between phases no samples are in progress, and the schedule chooses the
// next phase.
//
// The engine calls render() at most once per task. Private to transport/render.
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

    /// The position of a render that resumes nothing.
    [[nodiscard]] virtual RenderPosition beginning() const { return {}; }
    /// Called once a session, before its first phase. Not called if the render has to end before that.
    virtual void begin_session(const RenderState& /*state*/) {}
    /// Whether the render is complete; called between phases.
    [[nodiscard]] virtual bool finished(const RenderPosition& position) const = 0;
    /// Moves the position to the phase's first task, unless it is within the phase. Returns the end of its tasks.
    virtual std::uint64_t begin_phase(RenderPosition& position) = 0;
    /// Makes the worker add the samples of a task; called by many threads at once.
    virtual void render(std::uint64_t task, RenderWorker& worker) const = 0;
    /// Moves the position to the next phase, after all of the phase's tasks are in the frame buffer.
    virtual void end_phase(RenderState& state);

    /// Whether a record taken between two tasks of a phase is consistent.
    [[nodiscard]] virtual bool can_save_amid_phase() const { return true; }
    /// Whether threads must leave their batches because the phase takes too long. Called while threads work.
    [[nodiscard]] virtual bool overdue(const RenderState& /*state*/) const { return false; }
    /// Called after threads had to leave their batches because the phase took too long. Decides how the render
    /// continues.
    virtual Status after_overdue(RenderState& /*state*/) { return success(); }

    /// The forecast of the camera samples of the whole render, after `done`.
    [[nodiscard]] virtual display::Forecast expected_samples(std::uint64_t done, const RenderState& state) const = 0;
    /// The error; null if the schedule does not measure it.
    [[nodiscard]] virtual const display::AdaptiveProgress* error() const { return nullptr; }
    /// The number of pixels that have their maximum of samples and an error above the tolerance.
    [[nodiscard]] virtual std::uint64_t unconverged() const { return 0; }
    /// The budget, or the number that the render reached.
    [[nodiscard]] virtual std::uint64_t samples_per_pixel() const = 0;

    /// The name of the schedule's own section in a checkpoint; empty: none.
    [[nodiscard]] virtual std::string section() const { return {}; }
    virtual void append_record(std::string& /*bytes*/) const {}
    virtual Status restore_record(std::string_view /*bytes*/) { return success(); }
};

/// Makes the schedule of the job's budget. Both arguments must outlive it.
std::unique_ptr<Schedule> make_schedule(const PreparedJob& prepared, const RenderTarget& target);

}  // namespace raylex::transport
