// The threads of a render, which process the tasks of a phase. Private to transport/render.
#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "transport/render/stages/render_state.h"

namespace raylex::transport {

class TaskRunner {
  public:
    /// When `*stop` (may be null) is set, threads finish their tasks, but leave a batch that takes longer than a
    /// moment.
    TaskRunner(RenderState& state, const std::atomic<bool>* stop)
        : state_(state), stop_(stop), fewest_threads_(state.workers.size()) {}

    /// Runs the tasks from the state's position up to task `end`, and moves the position. `meanwhile` is called on this
    /// thread at least every `interval` seconds; if it returns true, threads stop at the ends of their tasks. Returns
    /// an Error if a thread threw. If the system starts fewer threads than there are workers, those do all the work; if
    /// it starts none, this thread does.
    Status run(const Schedule& schedule, std::uint64_t end, double interval, const std::function<bool()>& meanwhile);

    [[nodiscard]] bool stopped() const { return stop_ != nullptr && stop_->load(std::memory_order_relaxed); }
    /// Whether the render has to end, because of `*stop` or because batches were left.
    [[nodiscard]] bool ending() const { return stopped() || state_.leave.load(std::memory_order_relaxed); }

    /// The smallest number of threads of all runs so far.
    [[nodiscard]] std::size_t fewest_threads() const { return fewest_threads_; }

  private:
    /// Calls `between`, unless empty, after each task.
    void work(const Schedule& schedule, RenderWorker& worker, std::uint64_t end, const std::function<void()>& between);
    void fail(const char* why);
    void watch_threads(const Schedule& schedule);
    void take_unfinished(std::uint64_t end);

    RenderState& state_;
    const std::atomic<bool>* stop_;
    std::size_t fewest_threads_;
    std::optional<double> stop_seen_;  // RenderState::seconds()
    std::atomic<std::uint64_t> next_{0}, next_unfinished_{0};
    std::atomic<bool> failed_{false}, pause_{false};
    std::mutex mutex_;                        // protects the members below
    std::vector<UnfinishedTask> left_tasks_;  // by threads that had to stop
    std::string failure_;
};

}  // namespace raylex::transport
