// Objects that Python gets for one call and may keep for longer: what they point to is gone once the call has returned.
#pragma once

#include <atomic>

#include "experiments/python/bindings/bindings.h"

namespace raylex::python {

class CallScope {
  public:
    /// `over` is the error of a use after the call.
    explicit CallScope(const char* over) : over_(over) {}
    void check() const {
        if (ended_) fail(over_);
    }

    /// A use that lets go of Python's lock at some point. Python's other threads may have one when the call returns:
    /// end() waits for it. Made and destroyed with the lock held.
    class Use {
      public:
        explicit Use(const CallScope& scope) : scope_(scope) {
            scope.check();
            ++scope.uses_;
        }
        ~Use() {
            --scope_.uses_;
            scope_.uses_.notify_all();
        }
        Use(const Use&) = delete;
        Use& operator=(const Use&) = delete;

      private:
        const CallScope& scope_;
    };

    void end() {
        while (const int uses = uses_.load()) {
            const py::gil_scoped_release released;
            uses_.wait(uses);
        }
        ended_ = true;
    }

  private:
    const char* over_;
    bool ended_ = false;
    mutable std::atomic<int> uses_{0};
};

/// What `work` gives, done on what `scope` points to while other Python threads run.
template <class Work>
auto unlocked(const CallScope& scope, Work&& work) {
    const Call call;  // the first: a thread that it keeps has no use for end() to wait for
    const CallScope::Use use(scope);
    const py::gil_scoped_release released;
    return work();
}

}  // namespace raylex::python
