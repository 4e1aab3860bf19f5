// Classes in Python behind the registries that plugins register with: their parameters are those that __init__ takes by
// name, with a default that says the type.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "display/services/registry.h"
#include "experiments/python/bindings/bindings.h"
#include "experiments/python/bindings/run_control.h"
#include "transport/textures/parameter_reader.h"

namespace raylex::python {

/// A class that Python registered.
struct PythonClass {
    std::string kind, name, help;
    py::object type;
    std::vector<ParameterDescription> parameters;
    py::dict defaults;
};

/// `defaults`: {parameter: value}, bool, int, float or str. Errors: any other.
std::shared_ptr<const PythonClass> describe_class(const std::string& kind, const std::string& name,
                                                  const std::string& help, const py::object& type,
                                                  const py::dict& defaults);

/// An instance, its parameters as `reader` has them; `more` override. Errors: reader's; what the class raises.
Result<py::object> make_instance(const PythonClass& python, transport::ParameterReader& reader,
                                 const std::vector<std::pair<std::string, std::int64_t>>& more = {});

/// Holds an object of Python in one of C++ that any thread may destroy.
class Held {
  public:
    explicit Held(py::object object) : object_(new py::object(std::move(object))) {}
    ~Held() {
        const Callback locked;
        delete object_;
    }
    Held(const Held&) = delete;
    Held& operator=(const Held&) = delete;
    /// With Python's lock held.
    [[nodiscard]] const py::object& operator*() const { return *object_; }

  private:
    py::object* object_;
};

/// Registers, in place of what Python registered under this name before. Errors: the name is raylex's own or a
/// plugin's.
void claim_name(const std::string& kind, const std::string& name, bool taken);

/// Calls `work` with Python's lock; what it throws ends the render that `control` is of, or goes on where there is
/// none.
template <class Work>
void guarded_call(const std::shared_ptr<RunControl>& control, Work&& work) {
    const Callback locked;
    if (control && control->failed()) return;
    try {
        work();
    } catch (...) {
        if (!control) throw;
        control->fail_with_current();
    }
}

}  // namespace raylex::python
