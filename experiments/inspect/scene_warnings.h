// Finds likely mistakes in a scene that renders, for `raylex scene check`.
#pragma once

#include <vector>

#include "transport/render/built_scene.h"

namespace raylex::experiments {

/// Returns one warning per object, located at its directive, in file order: degenerate texture coordinates on textured
/// shapes, vertex normals on both sides of their face, lights without power, and unused definitions with the closest
/// used name. `built` must be built from `scene`.
std::vector<Error> scene_warnings(const transport::SceneDescription& scene, const transport::BuiltScene& built);

}  // namespace raylex::experiments
