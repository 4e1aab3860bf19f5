// The mean of an image texture: what stands for it where image textures are left out.
#pragma once

#include <array>

#include "lpe/result.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

/// Over all texels, of what the imagemap `source` gives there: its scale, inversion and the reading of its file
/// included, in the scene's colour space. A float texture's stands in all three. Errors: the file cannot be read; a
/// parameter is of the wrong type.
Result<std::array<double, 3>> mean_of_image(const SceneTexture& source, const ColorContext& color);

}  // namespace raylex::transport
