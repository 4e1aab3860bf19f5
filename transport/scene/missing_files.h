// Placeholders for files that a scene refers to and that do not exist.
#pragma once

#include <string>

#include "transport/scene/scene_description.h"

namespace raylex::transport {

enum class MissingFiles : std::uint8_t {
    refused,      ///< an error that names file, line and the folders searched
    placeholders  ///< magenta replaces them: images of textures and lights, measured materials, meshes
};

/// Converts an entity whose file `parameter` is missing to one without a file, magenta (1, 0, 1) if it has a colour. A
/// normal map is dropped, a float texture is 1, and lights that project images emit magenta in all directions. Returns
/// false for entities without a placeholder: lenses, grids of media.
bool make_placeholder(SceneEntity& entity, const Parameter& parameter, bool is_float_texture);

}  // namespace raylex::transport
