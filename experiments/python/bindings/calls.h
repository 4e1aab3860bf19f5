// Calls that release Python's lock, and the end of the interpreter. Python ends a daemon thread that then takes the
// lock again in the middle of C++ code, which would abort the program.
#pragma once

#include <pybind11/pybind11.h>

#include <atomic>

namespace raylex::python {

/// Exists from before the lock is released until after it is taken again. At the end of the interpreter, end_all() sets
/// `*stop` and waits for all calls; a call of a daemon thread then never returns. Calls within a Callback return,
/// because the call that the interpreter waits for needs them. Error: a call that begins in a Callback at that time, so
/// that the callback ends.
class Call {
  public:
    explicit Call(std::atomic<bool>* stop = nullptr);
    ~Call();
    Call(const Call&) = delete;
    Call& operator=(const Call&) = delete;
    /// The function that atexit runs.
    static void end_all();

  private:
    std::atomic<bool>* stop_;
};

/// Holds Python's lock on a C++ thread that calls Python during a Call.
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

/// Releases Python's lock while it exists.
struct Unlocked {
    Unlocked() = default;  // no aggregate: pybind11 makes it from {}, and the constructors of its members are explicit
    Call call;
    pybind11::gil_scoped_release released;
};

}  // namespace raylex::python
