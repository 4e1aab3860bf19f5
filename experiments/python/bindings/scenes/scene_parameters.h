// Conversion of Python values for a SceneBuilder: parameters, transforms, rows of coordinates.
#pragma once

#include <string>
#include <vector>

#include "experiments/python/bindings/arrays.h"
#include "transport/import/builder/scene_builder.h"
#include "transport/import/known_parameters.h"

namespace raylex::python {

/// Returns the Python source line of the call: "scene.py", line 12.
SourceLocation caller();
[[noreturn]] void fail_here(std::string message, std::string hint = {});
/// Returns a value with its type as text: "5, a int".
std::string shown(const py::handle& value);

/// Returns the parameters of a call: the dictionary `parameters`, or None, and the keywords. Values without an explicit
/// type get the type that the parameter is known to have.
transport::SceneParameters parameters_of(transport::EntityKind kind, const std::string& type,
                                         const py::object& parameters, const py::kwargs& keywords);

/// Converts a row-major (4, 4) matrix, with points as columns; None is the identity. `what` names it in errors.
transport::Transform transform_of(const py::object& object, const char* what);
std::optional<transport::Transform> transform_or_none(const py::object& object, const char* what);

/// Convert arrays of shape (N, 3) and (N, 2). Errors: other shapes, values that are not real numbers.
std::vector<transport::StoredVec3> triples(const py::object& object, const std::string& what);
std::vector<transport::StoredVec2> pairs(const py::object& object, const std::string& what);
/// Converts an array of any shape with integers from 0 to `end` - 1; `of` names the counted items in errors.
Array<double> indices_of(const py::object& object, const std::string& what, std::size_t end, const std::string& of);
/// Calls check_shape() with the source line of the call.
template <class T>
void check_shape_here(const Array<T>& array, std::size_t rows, std::size_t columns, const std::string& what) {
    try {
        check_shape(array, rows, columns, what);
    } catch (const Failure& failure) { fail_here(failure.error.message); }
}

}  // namespace raylex::python
