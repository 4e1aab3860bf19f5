// A scene for Python: the description from the importer or a builder.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "transport/scene/scene_description.h"

namespace raylex::python {

struct Scene {
    std::shared_ptr<const transport::SceneDescription> description;
    std::vector<transport::LabelRule> label_rules{};  ///< applied to every copy before its use
};

/// Returns the scene with its rules applied.
transport::SceneDescription labelled(const Scene& scene);

}  // namespace raylex::python
