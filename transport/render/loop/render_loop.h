// The fourth stage: the loop over phases, by whatever schedule the budget makes. Private to transport/render.
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

/// What a loop came to, beside what is in its RenderTarget; only RenderLoop::run() makes one.
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
    /// Ready to run, where a checkpoint left off if one is to be resumed. Both must outlive the loop; `since_call`
    /// began when the render was asked for; `earlier` is what buckets before it took.
    static Result<std::unique_ptr<RenderLoop>> begin(const PreparedJob& prepared, RenderTarget& target,
                                                     const Stopwatch& since_call, const RenderStatistics& earlier = {});

    /// Whether a checkpoint had all there is to do.
    [[nodiscard]] bool finished() const { return schedule_->finished(state_.position); }
    /// After run(): saves what it came to, as a checkpoint that has all.
    Status keep() { return saver_->keep(state_); }
    /// Returns when the budget is spent, the time is over or `*stop` was seen; an Error when a thread ran out of
    /// memory. Once.
    Result<FinishedLoop> run(const std::function<void(const RenderProgress&)>& progress, const std::atomic<bool>* stop);

  private:
    RenderLoop(const PreparedJob& prepared, RenderTarget& target, std::unique_ptr<Schedule> schedule,
               const Stopwatch& since_call)
        : schedule_(std::move(schedule)), state_(prepared, target, *schedule_, since_call) {}

    Status start_up(TaskRunner& runner, const std::function<void()>& report);
    Status run_phases(TaskRunner& runner, const std::function<void()>& report);
    /// The tasks of the phase that the position is in, with what the integrator does around them. Returns whether all
    /// of them are in the frame buffer; not so when the render has to end.
    Result<bool> run_phase(TaskRunner& runner, const std::function<void()>& report);
    FinishedLoop finish();

    std::unique_ptr<Schedule> schedule_;
    RenderState state_;
    std::optional<RenderSaver> saver_;
    std::uint64_t resumed_samples_ = 0, untraced_before_ = 0;
    double start_up_seconds_ = 0, start_up_cpu_seconds_ = 0;  // counted as preparation
};

}  // namespace raylex::transport
