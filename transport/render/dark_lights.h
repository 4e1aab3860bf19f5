// Finds reasons for a black image in a valid scene.
#pragma once

#include <vector>

#include "transport/lights/light_table.h"
#include "transport/media/medium.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

/// Returns a warning if the scene has no light at all, and one for each light that emits nothing. An area light emits
/// nothing if none of its primitives does.
std::vector<Error> find_dark_lights(const SceneDescription& scene, const LightTable& lights, const MediumTable& media);

}  // namespace raylex::transport
