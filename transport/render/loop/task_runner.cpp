#include "transport/render/loop/task_runner.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <memory>
#include <new>
#include <thread>

#include "display/services/processor.h"
#include "display/services/thread_or_none.h"
#include "transport/render/clock.h"

namespace raylex::transport {
namespace {

/// The time for which threads may continue their batches after a stop. Threads are checked every 0.2 s, which together
/// leaves a render half a second to end.
constexpr double stop_grace_seconds = 0.15;

}  // namespace

void TaskRunner::work(const Schedule& schedule, RenderWorker& worker, std::uint64_t end,
                      const std::function<void()>& between) {
    display::flush_denormals();  // row 32 of the hard cases: a throughput that stays denormal slows every product
    const double begin = thread_cpu_seconds();
    const std::vector<UnfinishedTask>& unfinished = state_.position.unfinished;
    try {
        while (!failed_.load(std::memory_order_relaxed)) {
            if (ending() || pause_.load(std::memory_order_relaxed)) break;
            UnfinishedTask part;
            if (const std::uint64_t k = next_unfinished_.fetch_add(1); k < unfinished.size()) {
                part = unfinished[k];
            } else {
                part.task = next_.fetch_add(1, std::memory_order_relaxed);
                if (part.task >= end) break;
            }
            const std::uint64_t before = worker.samples;
            worker.begin_task(part.done);
            schedule.render(part.task, worker);
            worker.end_task();
            state_.samples_done.fetch_add(worker.samples - before, std::memory_order_relaxed);
            if (between) between();
            if (!worker.left()) continue;
            const std::lock_guard lock(mutex_);
            left_tasks_.push_back({part.task, worker.done()});
            break;
        }
    } catch (const std::exception& e) { fail(e.what()); } catch (...) {
        fail("a plugin threw an object that is not a std::exception");
    }
    worker.cpu_seconds += thread_cpu_seconds() - begin;
}

void TaskRunner::fail(const char* why) {
    const std::lock_guard lock(mutex_);
    if (failure_.empty()) failure_ = why;
    failed_.store(true);
}

void TaskRunner::watch_threads(const Schedule& schedule) {
    const double now = state_.seconds();
    if (stopped() && !stop_seen_) stop_seen_ = now;
    if ((stop_seen_ && now - *stop_seen_ > stop_grace_seconds) || schedule.overdue(state_))
        state_.leave.store(true, std::memory_order_relaxed);
}

/// Tasks are taken in order: the frame buffer contains all tasks before the next one, except those that threads had to
/// leave, and no others.
void TaskRunner::take_unfinished(std::uint64_t end) {
    state_.position.task = std::min(next_.load(), end);
    std::vector<UnfinishedTask>& unfinished = state_.position.unfinished;
    const auto taken = std::min<std::uint64_t>(next_unfinished_.load(), unfinished.size());
    unfinished.erase(unfinished.begin(), unfinished.begin() + static_cast<std::ptrdiff_t>(taken));
    unfinished.insert(unfinished.end(), left_tasks_.begin(), left_tasks_.end());
    left_tasks_.clear();
    std::sort(unfinished.begin(), unfinished.end(), [](const auto& a, const auto& b) { return a.task < b.task; });
}

Status TaskRunner::run(const Schedule& schedule, std::uint64_t end, double interval,
                       const std::function<bool()>& meanwhile) {
    next_.store(state_.position.task);
    next_unfinished_.store(0);
    pause_.store(false);
    std::mutex mutex;
    std::condition_variable done;
    std::size_t running = 0;
    std::vector<std::thread> threads;
    const auto look = [&] {
        watch_threads(schedule);
        if (meanwhile()) pause_.store(true, std::memory_order_relaxed);
    };
    {
        // If stacks use up the address space, some must remain for rendering.
        std::unique_ptr<char[]> reserve(new (std::nothrow) char[std::size_t{256} << 20]);
        std::unique_lock lock(mutex);  // threads that finish early wait until all are counted
        for (auto& worker : state_.workers) {
            std::thread thread = display::thread_or_none([&, w = worker.get()] {
                work(schedule, *w, end, {});
                const std::lock_guard counted(mutex);
                --running;
                done.notify_one();
            });
            if (!thread.joinable()) break;
            threads.push_back(std::move(thread));
            ++running;
        }
        reserve.reset();
        while (!done.wait_for(lock, std::chrono::duration<double>(interval), [&] { return running == 0; })) {
            lock.unlock();
            look();
            lock.lock();
        }
    }
    if (threads.empty()) work(schedule, *state_.workers.front(), end, look);
    fewest_threads_ = std::min(fewest_threads_, std::max<std::size_t>(1, threads.size()));
    for (std::thread& thread : threads) thread.join();
    if (failed_.load()) return error_at({}, "a render thread failed: " + failure_);
    take_unfinished(end);
    return success();
}

}  // namespace raylex::transport
