// Whether meshes enclose something, and on which side.
#pragma once

#include <optional>

#include "transport/scene/scene_description.h"

namespace raylex::experiments {

/// Of a triangle mesh in which every edge has two faces, in the space it was written in: the volume behind its faces.
/// Below 0: they face inwards, so that all of space is inside. Nothing for other shapes and meshes that are open.
/// Vertices in the same place count as one. Faces face as pbrt-v4 turns them: by vertex normals where there are any,
/// else by their winding; ReverseOrientation turns both.
std::optional<double> enclosed_volume(const transport::SceneShape& shape);

}  // namespace raylex::experiments
