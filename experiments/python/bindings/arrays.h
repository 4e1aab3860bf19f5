// Conversion between C++ values and NumPy arrays. Returned arrays own the values of C++, without a copy. Arguments of
// the right type and order are read in place; others are converted once.
#pragma once

#include <pybind11/numpy.h>

#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "experiments/python/bindings/bindings.h"
#include "transport/math/vec.h"

namespace raylex::python {

template <class T>
using Array = py::array_t<T, py::array::c_style | py::array::forcecast>;

/// Returns an array of this shape that owns the values.
template <class T>
py::array_t<T> owning_array(std::vector<T> values, std::vector<py::ssize_t> shape) {
    auto kept = std::make_unique<std::vector<T>>(std::move(values));
    T* const data = kept->data();
    const py::capsule owner(kept.release(), [](void* p) { delete static_cast<std::vector<T>*>(p); });
    return py::array_t<T>(std::move(shape), data, owner);
}

/// Returns a read-only array of values that the Python object `owner` keeps alive.
template <class T>
py::array_t<T> view_of(const std::vector<T>& values, std::vector<py::ssize_t> shape, const py::handle& owner) {
    py::array_t<T> array(std::move(shape), values.data(), owner);
    array.attr("setflags")(py::arg("write") = false);
    return array;
}

/// Returns the shape as text: "(128, 3)".
inline std::string shape_text(const py::array& array) {
    std::string text = "(";
    for (py::ssize_t i = 0; i < array.ndim(); ++i) text += (i > 0 ? ", " : "") + std::to_string(array.shape(i));
    return text + (array.ndim() == 1 ? ",)" : ")");
}

/// Checks that the array has `rows` rows of `columns` numbers (0: one number per row, shape (rows,)). `what` names it
/// in the error.
template <class T>
void check_shape(const Array<T>& array, std::size_t rows, std::size_t columns, const std::string& what) {
    const bool right = columns == 0 ? array.ndim() == 1 && array.shape(0) == static_cast<py::ssize_t>(rows)
                                    : array.ndim() == 2 && array.shape(0) == static_cast<py::ssize_t>(rows) &&
                                          array.shape(1) == static_cast<py::ssize_t>(columns);
    if (right) return;
    fail(what + " has shape " + shape_text(array) + "; expected (" + std::to_string(rows) +
         (columns == 0 ? ",)" : ", " + std::to_string(columns) + ")"));
}

/// Converts an argument to an array of T. Error: it is not an array of numbers; `what` names it in the error.
template <class T>
Array<T> array_of(const py::handle& object, const std::string& what) {
    Array<T> array = Array<T>::ensure(object);
    if (array) return array;
    PyErr_Clear();
    fail(what + " is " + std::string(py::str(py::type::handle_of(object).attr("__name__"))) +
         ", which is not an array of numbers; expected a NumPy array");
}

/// Values of shape (rows, 3): one row per row, one number for all, or one row for all.
class Triples {
  public:
    Triples(const py::handle& object, std::size_t rows, const std::string& what)
        : array_(array_of<float>(object, what)) {
        const bool scalar = array_.ndim() == 0, row = array_.ndim() == 1 && array_.shape(0) == 3;
        if (!scalar && !row) check_shape(array_, rows, 3, what);
        step_ = scalar ? 0 : 1;
        stride_ = scalar || row ? 0 : 3;
    }
    [[nodiscard]] transport::Rgb operator[](std::size_t i) const {
        const float* const at = array_.data() + i * stride_;
        return {at[0], at[step_], at[2 * step_]};
    }
    [[nodiscard]] transport::Vec3 vec(std::size_t i) const {
        const transport::Rgb value = (*this)[i];
        return {value.r, value.g, value.b};
    }

  private:
    Array<float> array_;
    std::size_t step_ = 1, stride_ = 3;
};

}  // namespace raylex::python
