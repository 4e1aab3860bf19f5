#include "experiments/python/bindings/calls.h"

#include <unistd.h>

#include <condition_variable>
#include <mutex>
#include <optional>
#include <set>
#include <thread>

#include "experiments/python/bindings/bindings.h"

namespace raylex::python {
namespace {

struct Calls {
    std::mutex mutex;
    std::condition_variable over;
    std::multiset<std::atomic<bool>*> stops;  // of calls in progress; null for calls that cannot be stopped
    std::optional<std::thread::id> ender;     // the thread that ends the interpreter
    bool ending = false;                      // that thread waits for `stops`; later calls are its own
};

/// Never destroyed, because threads may outlive main().
Calls& calls() {
    static auto* const all = new Calls;
    return *all;
}

/// If the interpreter is ending, blocks every thread that is not joined, without Python's lock.
void stay_if_ending(std::unique_lock<std::mutex>& lock) {
    if (Callback::here() || !calls().ender || *calls().ender == std::this_thread::get_id()) return;
    lock.unlock();
    PyEval_SaveThread();
    for (;;) pause();
}

}  // namespace

Call::Call(std::atomic<bool>* stop) : stop_(stop) {
    std::unique_lock lock(calls().mutex);
    if (Callback::here() && calls().ending)
        fail("the interpreter is ending, which stops this render; expected no further calls of raylex");
    stay_if_ending(lock);
    calls().stops.insert(stop_);
}

Call::~Call() {
    std::unique_lock lock(calls().mutex);
    calls().stops.erase(calls().stops.find(stop_));
    calls().over.notify_all();
    stay_if_ending(lock);
}

void Call::end_all() {
    const pybind11::gil_scoped_release released;
    Calls& all = calls();
    std::unique_lock lock(all.mutex);
    all.ender = std::this_thread::get_id();
    for (std::atomic<bool>* stop : all.stops)
        if (stop != nullptr) stop->store(true);
    all.ending = true;
    all.over.wait(lock, [&] { return all.stops.empty(); });
    all.ending = false;
}

}  // namespace raylex::python
