// Shared declarations of the Python module: one function for each part, and errors as exceptions.
//
// Bindings are thin: they convert arguments, call the functions that the program calls, and return their results. Long
// work runs without Python's global lock.
#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <utility>

#include "experiments/python/bindings/calls.h"
#include "lpe/result.h"

namespace raylex::python {

namespace py = pybind11;

// Each function adds its classes and functions to the module `raylex._raylex`.
void add_errors(py::module_& module);
void add_lpe(py::module_& module);
void add_lpe_relations(py::module_& module);
void add_scene(py::module_& module);
void add_scene_builder(py::module_& module);
void add_image(py::module_& module);
void add_atlas(py::module_& module);
void add_checks(py::module_& module);
void add_render(py::module_& module);
void add_study(py::module_& module);
void add_plugins(py::module_& module);
void add_integrators(py::module_& module);
void add_points(py::module_& module);

/// An Error as a C++ exception, which pybind11 converts to raylex.RaylexError.
struct Failure {
    Error error;
};

/// Returns the value, or throws the Error.
template <class T>
T take(Result<T> result) {
    if (!result) throw Failure{std::move(result).error()};
    return *std::move(result);
}
inline void take(const Status& status) {
    if (!status) throw Failure{status.error()};
}
[[noreturn]] inline void fail(std::string message, std::string hint = {}) {
    Error error;
    error.message = std::move(message);
    error.hint = std::move(hint);
    throw Failure{std::move(error)};
}

/// Returns the result of `work`, which runs while other Python threads run. It must not use Python objects.
template <class Work>
auto unlocked(Work&& work) {
    const Unlocked released;
    return work();
}

/// Returns the pending Python exception as an Error with its traceback in the hint; `where` names the callback.
Error error_of(const py::error_already_set& exception, const std::string& where);

}  // namespace raylex::python
