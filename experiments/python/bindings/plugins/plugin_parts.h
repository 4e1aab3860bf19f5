// The parts of raylex.plugins, each in its own file.
#pragma once

#include "experiments/python/bindings/bindings.h"

namespace raylex::python {

void add_textures(py::module_& module);
void add_filters(py::module_& module);

}  // namespace raylex::python
