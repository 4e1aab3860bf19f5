// What the files of the Python module share: one function a part of it, and errors as exceptions.
//
// Bindings are thin: they turn arguments into what the toolkit's own functions take, call those that the program calls,
// and hand out what these give. Work that takes time is done without Python's global lock.
#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <utility>

#include "experiments/python/bindings/calls.h"
#include "lpe/result.h"

namespace raylex::python {

namespace py = pybind11;

// Each adds its classes and functions to the module `raylex._raylex`.
void add_errors(py::module_& module);
void add_lpe(py::module_& module);
void add_lpe_relations(py::module_& module);
void add_scene(py::module_& module);
void add_scene_builder(py::module_& module);
void add_image(py::module_& module);
void add_atlas(py::module_& module);
void add_judging(py::module_& module);
void add_render(py::module_& module);
void add_study(py::module_& module);
void add_plugins(py::module_& module);
void add_integrators(py::module_& module);
void add_points(py::module_& module);

/// An Error on its way through C++ code that pybind11 calls; Python sees raylex.RaylexError.
struct Failure {
    Error error;
};

/// The value, or the Error as an exception.
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

/// What `work` gives, done while other Python threads run. It must not touch Python objects.
template <class Work>
auto unlocked(Work&& work) {
    const Unlocked released;
    return work();
}

/// The pending Python exception as an Error, its traceback in the hint; `where` says which callback threw it.
Error error_of(const py::error_already_set& exception, const std::string& where);

}  // namespace raylex::python
