// What of a scene renders, but hardly as somebody meant it: for `raylex scene check`.
#pragma once

#include <vector>

#include "transport/render/built_scene.h"

namespace raylex::experiments {

/// One an object, at its directive, in the order of the file: degenerate texture coordinates where textures read them,
/// vertex normals that lie on both sides of their face, lights without power, and what is defined and
/// never used, with the near miss that may have been meant. `built` is of `scene`.
std::vector<Error> scene_doubts(const transport::SceneDescription& scene, const transport::BuiltScene& built);

}  // namespace raylex::experiments
