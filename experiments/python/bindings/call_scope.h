// Python objects that are valid during one call. Python may keep them longer, but their data is gone after the call.
#pragma once

#include <atomic>

#include "experiments/python/bindings/bindings.h"

namespace raylex::python {

class CallScope {
  public:
    /// `over` is the error message for a use after the call.
    explicit CallScope(const char* over) : over_(over) {}
    void check() const {
        if (ended_) fail(over_);
    }

    /// A use that may release Python's lock. Other Python threads may be inside a use when the call returns; end()
    /// waits for them. Construct and destroy it with the lock held.
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

/// Returns the result of `work` on the data of `scope`, which runs while other Python threads run.
template <class Work>
auto unlocked(const CallScope& scope, Work&& work) {
    const Call call;  // first, because end() need not wait for a thread that this blocks
    const CallScope::Use use(scope);
    const py::gil_scoped_release released;
    return work();
}

}  // namespace raylex::python
