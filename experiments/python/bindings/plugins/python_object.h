// Python classes in the registries of plugins. Their parameters are the keyword arguments of __init__; the default of
// each determines its type.
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

/// Describes a class. `defaults` is {parameter: value} with bool, int, float or str values. Error: any other value.
std::shared_ptr<const PythonClass> describe_class(const std::string& kind, const std::string& name,
                                                  const std::string& help, const py::object& type,
                                                  const py::dict& defaults);

/// Makes an instance with the parameters in `reader`; `more` overrides them. Errors: those of the reader; exceptions of
/// the class.
Result<py::object> make_instance(const PythonClass& python, transport::ParameterReader& reader,
                                 const std::vector<std::pair<std::string, std::int64_t>>& more = {});

/// Holds a Python object in a C++ object that any thread may destroy.
class Held {
  public:
    explicit Held(py::object object) : object_(new py::object(std::move(object))) {}
    ~Held() {
        const Callback locked;
        delete object_;
    }
    Held(const Held&) = delete;
    Held& operator=(const Held&) = delete;
    /// Call it with Python's lock held.
    [[nodiscard]] const py::object& operator*() const { return *object_; }

  private:
    py::object* object_;
};

/// Claims a name for a registration. A class that Python registered earlier under this name is replaced. Error: the
/// name belongs to raylex or a plugin.
void claim_name(const std::string& kind, const std::string& name, bool taken);

/// Calls `work` with Python's lock. An exception ends the render of `control`; without a render it is thrown on.
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
