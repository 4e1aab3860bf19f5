#include "experiments/python/bindings/plugins/python_object.h"

#include <pybind11/stl.h>

#include <set>
#include <utility>

namespace raylex::python {

namespace {

ParameterDescription describe_parameter(const std::string& name, const py::handle& value) {
    ParameterDescription parameter;
    parameter.name = name;
    parameter.fallback = py::str(value);
    if (py::isinstance<py::bool_>(value)) {
        parameter.type = ParameterType::boolean;
        parameter.fallback = value.cast<bool>() ? "true" : "false";
    } else if (py::isinstance<py::int_>(value)) {
        parameter.type = ParameterType::integer;
    } else if (py::isinstance<py::float_>(value)) {
        parameter.type = ParameterType::real;
    } else if (py::isinstance<py::str>(value)) {
        parameter.type = ParameterType::string;
    } else {
        fail("parameter '" + name + "' has the default " + std::string(py::repr(value)) +
             "; expected a bool, int, float or str, which determines its type");
    }
    return parameter;
}

}  // namespace

std::shared_ptr<const PythonClass> describe_class(const std::string& kind, const std::string& name,
                                                  const std::string& help, const py::object& type,
                                                  const py::dict& defaults) {
    auto described = std::make_unique<PythonClass>();
    described->kind = kind;
    described->name = name;
    described->help = help;
    described->type = type;
    described->defaults = defaults;
    for (const auto& [parameter, value] : defaults)
        described->parameters.push_back(describe_parameter(parameter.cast<std::string>(), value));
    // Registries live as long as the process, and so do their classes, so no Python object is destroyed after the
    // interpreter.
    return {described.release(), [](const PythonClass*) {}};
}

Result<py::object> make_instance(const PythonClass& python, transport::ParameterReader& reader,
                                 const std::vector<std::pair<std::string, std::int64_t>>& more) {
    py::dict values;
    for (const auto& [key, value] : python.defaults) {
        const std::string name = key.cast<std::string>();
        if (py::isinstance<py::bool_>(value)) values[key] = reader.boolean(name, value.cast<bool>());
        else if (py::isinstance<py::int_>(value))
            values[key] = reader.take(reader.set().integer_or(name, value.cast<std::int64_t>()), std::int64_t{0});
        else if (py::isinstance<py::float_>(value))
            values[key] = reader.take(reader.set().real_or(name, value.cast<double>()), 0.0);
        else values[key] = reader.string(name, value.cast<std::string>());
    }
    if (reader.error()) return *reader.error();
    for (const auto& [name, value] : more)
        if (values.contains(name)) values[py::str(name)] = value;
    try {
        return py::object(python.type(**values));
    } catch (const py::error_already_set& exception) {
        Error error = error_of(exception, "making the " + python.kind + " '" + python.name + "'");
        error.file = reader.set().location.file;
        error.line = reader.set().location.line;
        return error;
    }
}

void claim_name(const std::string& kind, const std::string& name, bool taken) {
    static std::set<std::pair<std::string, std::string>> ours;
    if (name.empty()) fail("the " + kind + " has no name; expected a name for scenes and jobs");
    if (taken && !ours.contains({kind, name}))
        fail("the " + kind + " '" + name + "' exists already in raylex or a plugin; expected a different name");
    ours.emplace(kind, name);
}

}  // namespace raylex::python
