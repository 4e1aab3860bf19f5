// The fourth stage: the loop over phases, with the schedule that the budget selects. Private to transport/render.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "transport/render/loop/live_image.h"
#include "transport/render/loop/render_saver.h"
#include "transport/render/loop/task_runner.h"
#include "transport/render/stages/render_state.h"

namespace raylex::transport {

/// The result of a loop, beside its RenderTarget; only RenderLoop::run() makes one.
class FinishedLoop {
  public:
    RenderStatistics statistics;
    SamplesTaken samples;
    std::vector<Error> warnings;

  private:
    friend class RenderLoop;
    FinishedLoop() = default;
};

class RenderLoop {
  public:
    /// Prepares a loop, which continues from a checkpoint if one is to be resumed. Both arguments must outlive the
    /// loop. `since_call` runs since the call of render(); `earlier` contains the statistics of earlier buckets.
    static Result<std::unique_ptr<RenderLoop>> begin(const PreparedJob& prepared, RenderTarget& target,
                                                     const Stopwatch& since_call, const RenderStatistics& earlier = {});

    /// Whether a checkpoint contained the finished render.
    [[nodiscard]] bool finished() const { return schedule_->finished(state_.position); }
    /// Saves the result after run(), as a checkpoint of a finished render.
    Status keep() { return saver_->keep(state_); }
    /// Runs once, until the budget is spent, the time is over or `*stop` is set. Returns an Error if a thread ran out
    /// of memory.
    Result<FinishedLoop> run(const std::function<void(const RenderProgress&)>& progress, const std::atomic<bool>* stop);

  private:
    RenderLoop(const PreparedJob& prepared, RenderTarget& target, std::unique_ptr<Schedule> schedule,
               const Stopwatch& since_call)
        : schedule_(std::move(schedule)), state_(prepared, target, *schedule_, since_call) {}

    Status start_up(TaskRunner& runner, const std::function<void()>& report);
    Status run_phases(TaskRunner& runner, const std::function<void()>& report);
    /// Runs the tasks of the current phase, and the integrator's work around them. Returns true if all of them are in
    /// the frame buffer, false if the render has to end.
    Result<bool> run_phase(TaskRunner& runner, const std::function<void()>& report);
    FinishedLoop finish();

    std::unique_ptr<Schedule> schedule_;
    RenderState state_;
    std::optional<RenderSaver> saver_;
    std::uint64_t resumed_samples_ = 0, untraced_before_ = 0;
    double start_up_seconds_ = 0, start_up_cpu_seconds_ = 0;  // included in preparation
};

}  // namespace raylex::transport
