#include "experiments/python/bindings/bindings.h"

namespace raylex::python {

namespace {

/// Raises raylex.errors.RaylexError with the parts of the Error as attributes.
void raise(const Error& error) {
    const py::object type = py::module_::import("raylex.errors").attr("RaylexError");
    const py::object exception =
        type(error.to_string(), py::arg("message") = error.message, py::arg("file") = error.file,
             py::arg("line") = error.line, py::arg("column") = error.column, py::arg("excerpt") = error.excerpt,
             py::arg("hint") = error.hint);
    PyErr_SetObject(type.ptr(), exception.ptr());
}

}  // namespace

void add_errors(py::module_& /*module*/) {
    py::register_exception_translator([](std::exception_ptr pointer) {
        try {
            if (pointer) std::rethrow_exception(pointer);
        } catch (const Failure& failure) {
            try {
                raise(failure.error);
            } catch (py::error_already_set& other) { other.restore(); }
        }
    });
}

Error error_of(const py::error_already_set& exception, const std::string& where) {
    Error error;
    error.message = where + " raised " + std::string(py::str(exception.type().attr("__name__"))) + ": " +
                    std::string(py::str(exception.value()));
    return error;
}

}  // namespace raylex::python
