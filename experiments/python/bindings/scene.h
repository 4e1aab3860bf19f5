// A scene as Python has it: the description that the importer or a builder made.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "transport/scene/scene_description.h"

namespace raylex::python {

struct Scene {
    std::shared_ptr<const transport::SceneDescription> description;
    std::vector<transport::LabelRule> label_rules{};  ///< given to every copy before it is used
};

/// The scene with its rules applied.
transport::SceneDescription labelled(const Scene& scene);

}  // namespace raylex::python
