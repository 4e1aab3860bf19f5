// Why an image may be black although nothing is wrong with the scene.
#pragma once

#include <vector>

#include "transport/lights/light_table.h"
#include "transport/media/medium.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

/// That the scene has no light at all, or every light that gives none; an area light does if none of its primitives
/// shines.
std::vector<Error> find_dark_lights(const SceneDescription& scene, const LightTable& lights, const MediumTable& media);

}  // namespace raylex::transport
