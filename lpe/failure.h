// Inside lpe/ a stage that cannot continue throws a Failure; the public functions convert it to an Error value.
#pragma once

#include <utility>

#include "lpe/result.h"

namespace raylex::lpe {

struct Failure {
    Error error;
};

[[noreturn]] inline void fail(std::string message, std::string hint = {}) {
    Error error;
    error.message = std::move(message);
    error.hint = std::move(hint);
    throw Failure{std::move(error)};
}

/// Runs `work` and returns its value, or the Error of the Failure that it threw.
template <class Work>
auto guarded(Work&& work) -> Result<decltype(work())> {
    try {
        return work();
    } catch (Failure& failure) { return std::move(failure.error); }
}

}  // namespace raylex::lpe
