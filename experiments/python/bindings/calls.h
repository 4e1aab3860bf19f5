// Calls that let go of Python's lock, and the end of the interpreter: a daemon thread that takes the lock back then is
// ended amid C++ code, which aborts the whole program.
#pragma once

#include <pybind11/pybind11.h>

#include <atomic>

namespace raylex::python {

/// From before the lock is let go to after it is taken back. When the interpreter ends, it sets `*stop` and waits for
/// all calls; a call of a daemon thread then never returns. Calls within a Callback do return, since a call that the
/// interpreter waits for waits for them. Errors: a call that begins in a Callback meanwhile, so that the callback ends.
class Call {
  public:
    explicit Call(std::atomic<bool>* stop = nullptr);
    ~Call();
    Call(const Call&) = delete;
    Call& operator=(const Call&) = delete;
    /// What atexit runs.
    static void end_all();

  private:
    std::atomic<bool>* stop_;
};

/// Python's lock on a thread of C++ that calls Python amid a Call.
class Callback {
  public:
    Callback() { ++depth_; }
    ~Callback() { --depth_; }
    Callback(const Callback&) = delete;
    Callback& operator=(const Callback&) = delete;
    [[nodiscard]] static bool here() { return depth_ > 0; }

  private:
    pybind11::gil_scoped_acquire locked_;
    inline static thread_local int depth_ = 0;
};

/// Without Python's lock for as long as it lives.
struct Unlocked {
    Call call;
    pybind11::gil_scoped_release released;
};

}  // namespace raylex::python
