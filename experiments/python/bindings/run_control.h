// Control of a render that Python started: stopping it, and exceptions of callbacks.
//
// A render has its own threads, and a callback's exception must not leave them. The first exception is stored, ends the
// render, and is thrown again in the thread that called from Python.
#pragma once

#include <atomic>
#include <chrono>
#include <exception>
#include <future>
#include <memory>
#include <mutex>
#include <utility>

#include "experiments/python/bindings/bindings.h"

namespace raylex::python {

class RunControl {
  public:
    [[nodiscard]] std::atomic<bool>& stop_flag() { return stop_; }
    void stop() { stop_.store(true); }
    /// Stores the current exception, if it is the first one, and stops the render. Call it in a catch block.
    void fail_with_current() noexcept {
        const std::scoped_lock lock(mutex_);
        if (!failure_) failure_ = std::current_exception();
        stop();
    }
    [[nodiscard]] bool failed() const {
        const std::scoped_lock lock(mutex_);
        return failure_ != nullptr;
    }
    /// Throws the stored exception, if any.
    void rethrow() const {
        const std::scoped_lock lock(mutex_);
        if (failure_) std::rethrow_exception(failure_);
    }

    /// The control of the render that this thread sets up; null if there is none. Python objects take it when they are
    /// made.
    static std::shared_ptr<RunControl> current() { return current_; }

    class Scope {
      public:
        explicit Scope(std::shared_ptr<RunControl> control) { current_ = std::move(control); }
        ~Scope() { current_.reset(); }
        Scope(const Scope&) = delete;
        Scope& operator=(const Scope&) = delete;
    };

  private:
    std::atomic<bool> stop_{false};
    mutable std::mutex mutex_;
    std::exception_ptr failure_;
    static thread_local std::shared_ptr<RunControl> current_;
};

/// Runs `work` on a new thread while this one, which holds Python's lock, releases it for others and checks for Ctrl-C.
template <class Work>
auto watched(const std::shared_ptr<RunControl>& control, Work work) {
    const Call call(&control->stop_flag());
    auto result = std::async(std::launch::async, [&] {
        const RunControl::Scope scope(control);
        return work();
    });
    const auto done = [&] {
        const py::gil_scoped_release released;
        return result.wait_for(std::chrono::milliseconds(50)) == std::future_status::ready;
    };
    while (!done()) {
        try {
            if (PyErr_CheckSignals() != 0) throw py::error_already_set();
        } catch (const py::error_already_set&) { control->fail_with_current(); }
    }
    return result.get();
}

}  // namespace raylex::python
