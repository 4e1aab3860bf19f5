// Displaced meshes: triangles are split until their edges are short, then moved along their normals.
#pragma once

#include "lpe/result.h"
#include "transport/scene/scene_description.h"
#include "transport/textures/texture.h"

namespace raylex::transport {

/// Returns the triangles of `shape` with every edge halved until it is at most shape.edge_length long after
/// `placement`. Each vertex is moved by its displacement_texture along its normal (that of the file, or of the faces
/// around it), in the shape's own space and unit, as in pbrt-v4. Normals are those of the displaced mesh. Both faces of
/// an edge cut it alike, so a closed mesh stays closed, except at vertices that the file contains twice. Errors: not a
/// float texture, a value that is not finite, more triangles than the budget.
Result<SceneShape> displaced_mesh(const SceneShape& shape, const Transform& placement, const TextureTable& textures);

}  // namespace raylex::transport
