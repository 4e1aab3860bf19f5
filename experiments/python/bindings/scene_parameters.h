// Python's values as a SceneBuilder takes them: parameters, transforms, rows of coordinates.
#pragma once

#include <string>
#include <vector>

#include "experiments/python/bindings/arrays.h"
#include "transport/import/builder/scene_builder.h"
#include "transport/import/known_parameters.h"

namespace raylex::python {

/// Where in Python the call stands: "scene.py", line 12.
SourceLocation caller();
[[noreturn]] void fail_here(std::string message, std::string hint = {});
/// "5, a int".
std::string shown(const py::handle& value);

/// What a call of a type gives to it: the dictionary `parameters`, or None, and keywords. Values without a type of
/// their own get the one that the type is known to take.
transport::SceneParameters parameters_of(transport::EntityKind kind, const std::string& type,
                                         const py::object& parameters, const py::kwargs& keywords);

/// Row-major (4, 4), points are columns; None is the identity. `what` it is stands in errors.
transport::Transform transform_of(const py::object& object, const char* what);
std::optional<transport::Transform> transform_or_none(const py::object& object, const char* what);

/// (N, 3) and (N, 2). Errors: other shapes, and what are no real numbers.
std::vector<transport::StoredVec3> triples(const py::object& object, const std::string& what);
std::vector<transport::StoredVec2> pairs(const py::object& object, const std::string& what);
/// Whole numbers from 0 to below `end`, which is how many `of` there are, as an array of any shape.
Array<double> indices_of(const py::object& object, const std::string& what, std::size_t end, const std::string& of);
/// check_shape() with the place of the call.
template <class T>
void check_shape_here(const Array<T>& array, std::size_t rows, std::size_t columns, const std::string& what) {
    try {
        check_shape(array, rows, columns, what);
    } catch (const Failure& failure) { fail_here(failure.error.message); }
}

}  // namespace raylex::python
