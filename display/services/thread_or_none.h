// Threads where the system may start no more: a container's limit, or memory for stacks that is not there.
#pragma once

#include <system_error>
#include <thread>
#include <utility>

namespace raylex::display {

/// A thread that does `work`; not joinable when the system starts none, and then the caller does the work.
template <class Work>
std::thread thread_or_none(Work&& work) {
    try {
        return std::thread(std::forward<Work>(work));
    } catch (const std::system_error&) { return {}; }
}

}  // namespace raylex::display
