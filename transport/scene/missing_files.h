// What becomes of a scene when a file that it names is not there.
#pragma once

#include <string>

#include "transport/scene/scene_description.h"

namespace raylex::transport {

enum class MissingFiles : std::uint8_t {
    refused,      ///< an error that names file, line and the folders searched
    placeholders  ///< magenta takes their place: images of textures and lights, measured materials, meshes
};

/// Of an entity whose file `parameter` is missing: makes it one without a file, magenta (1, 0, 1) where it has a
/// colour. A normal map is left out, a float texture is 1, lights that throw images shine magenta in all directions.
/// False for what nothing can stand for: lenses, grids of media.
bool make_placeholder(SceneEntity& entity, const Parameter& parameter, bool is_float_texture);

}  // namespace raylex::transport
