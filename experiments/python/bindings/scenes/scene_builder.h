// Shared declarations of the Python SceneBuilder.
#pragma once

#include <string>
#include <utility>

#include "experiments/python/bindings/scenes/scene_parameters.h"
#include "transport/import/builder/scene_builder.h"

namespace raylex::python {

struct Builder {
    Builder(const std::string& name, transport::SearchPath search) : scene(name, std::move(search)) {}
    transport::SceneBuilder scene;
    bool finished = false;
    transport::SceneBuilder& open() {
        if (finished) fail_here("the builder's scene is finished; expected a new SceneBuilder");
        return scene;
    }
};

/// Returns a medium by its handle or name; None is vacuum. `what` names the argument in errors.
transport::MediumHandle medium_of(transport::SceneBuilder& scene, const py::object& medium, const char* what);

/// Adds the methods for shapes, objects and instances.
void add_shapes(py::class_<Builder>& builder);

}  // namespace raylex::python
