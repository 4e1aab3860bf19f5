// A scene's content as one number: the same scene gives the same number wherever its files lie, another one another.
#pragma once

#include <cstdint>

#include "transport/scene/scene_description.h"

namespace raylex::transport {

/// Of everything that can change an image: entities with their parameters, geometry, labels, groups, and the bytes of
/// the files that parameters name. What ColorContext::file_color does cannot be looked into and is the caller's to add.
[[nodiscard]] std::uint64_t scene_hash(const SceneDescription& scene);

}  // namespace raylex::transport
