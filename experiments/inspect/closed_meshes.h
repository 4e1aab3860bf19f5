// Checks whether meshes are closed, and on which side their volume is.
#pragma once

#include <optional>

#include "transport/scene/scene_description.h"

namespace raylex::experiments {

/// Returns the volume behind the faces of a triangle mesh, in the space of its vertices. Negative if the faces point
/// inwards, so that all outer space is "inside". Nothing for other shapes and for open meshes, where an edge does not
/// have two faces. Vertices at the same position count as one. Faces are oriented as in pbrt-v4: by vertex normals if
/// there are any, otherwise by winding; ReverseOrientation flips both.
std::optional<double> enclosed_volume(const transport::SceneShape& shape);

}  // namespace raylex::experiments
