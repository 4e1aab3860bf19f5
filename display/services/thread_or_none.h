// Starts threads on systems that may refuse more: a container's limit, or no memory for stacks.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace raylex::display {

/// A thread that runs `work`. If the system cannot start one, the result is not joinable, and the caller does the work.
template <class Work>
std::thread thread_or_none(Work&& work) {
    try {
        return std::thread(std::forward<Work>(work));
    } catch (const std::system_error&) { return {}; }
}

/// Calls work(0) to work(count - 1) once each, in any order. `threads` 0: one per core.
template <class Work>
void on_threads(std::size_t count, int threads, const Work& work) {
    if (count == 0) return;
    std::atomic<std::size_t> next{0};
    const auto run = [&] {
        for (std::size_t i; (i = next.fetch_add(1)) < count;) work(i);
    };
    const std::size_t cores =
        threads > 0 ? static_cast<std::size_t>(threads) : std::max(1u, std::thread::hardware_concurrency());
    std::vector<std::thread> others(std::min(cores, count) - 1);
    for (std::thread& each : others) each = thread_or_none(run);
    run();
    for (std::thread& each : others)
        if (each.joinable()) each.join();
}

}  // namespace raylex::display
