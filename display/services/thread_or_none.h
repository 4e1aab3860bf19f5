// Starts threads on systems that may refuse more: a container's limit, or no memory for stacks.
#pragma once

#include <system_error>
#include <thread>
#include <utility>

namespace raylex::display {

/// A thread that runs `work`. If the system cannot start one, the result is not joinable, and the caller does the work.
template <class Work>
std::thread thread_or_none(Work&& work) {
    try {
        return std::thread(std::forward<Work>(work));
    } catch (const std::system_error&) { return {}; }
}

}  // namespace raylex::display
