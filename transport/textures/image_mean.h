// The mean of an image texture, which replaces it if image textures are left out.
#pragma once

#include <array>

#include "lpe/result.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

/// The mean over all texels of the imagemap `source`, after its scale, inversion and file encoding, in the scene's
/// colour space. All three components are equal for a float texture. Errors: the file cannot be read; a parameter has
/// the wrong type.
Result<std::array<double, 3>> mean_of_image(const SceneTexture& source, const ColorContext& color);

}  // namespace raylex::transport
