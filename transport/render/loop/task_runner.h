// The threads of a render: they go through the tasks of a phase. Private to transport/render.
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
    /// Setting `*stop`, which may be null, has threads finish their tasks; a batch that takes them longer than a moment
    /// is left.
    TaskRunner(RenderState& state, const std::atomic<bool>* stop)
        : state_(state), stop_(stop), fewest_threads_(state.workers.size()) {}

    /// From the state's position up to task `end`; the position then says how far it came. `meanwhile` is called on
    /// this thread, every `interval` seconds at least; what it returns is whether threads shall stop at the ends of
    /// their tasks. An Error when a thread threw. Where the system starts fewer threads than there are workers, those
    /// do all; where it starts none, this one does.
    Status run(const Schedule& schedule, std::uint64_t end, double interval, const std::function<bool()>& meanwhile);

    [[nodiscard]] bool stopped() const { return stop_ != nullptr && stop_->load(std::memory_order_relaxed); }
    /// Whether the render has to end, by `*stop` or because batches were left.
    [[nodiscard]] bool ending() const { return stopped() || state_.leave.load(std::memory_order_relaxed); }

    /// Of all runs so far.
    [[nodiscard]] std::size_t fewest_threads() const { return fewest_threads_; }

  private:
    /// `between`, which may be empty, is called after each task.
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
    std::mutex mutex_;                        // of what follows
    std::vector<UnfinishedTask> left_tasks_;  // by threads that had to leave
    std::string failure_;
};

}  // namespace raylex::transport
