// A hash of a scene's content: equal scenes have the same number wherever their files are; different scenes differ.
#pragma once

#include <cstdint>

#include "transport/scene/scene_description.h"

namespace raylex::transport {

/// The hash of everything that can change an image: entities with their parameters, geometry, labels, groups, and the
/// bytes of the files that parameters name. The effect of ColorContext::file_color cannot be inspected, so the caller
/// adds it.
[[nodiscard]] std::uint64_t scene_hash(const SceneDescription& scene);

}  // namespace raylex::transport
