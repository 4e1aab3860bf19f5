// Displaced meshes: cut until their edges are short, then moved along their normals.
#pragma once

#include "lpe/result.h"
#include "transport/scene/scene_description.h"
#include "transport/textures/texture.h"

namespace raylex::transport {

/// The triangles of `shape` with every edge halved until `placement` makes it at most shape.edge_length long, each
/// vertex moved by its displacement_texture along its normal (that of the file, or of the faces around it; in the
/// shape's own space and unit, as in pbrt-v4), and the normals of what that gives. An edge is cut alike in both of its
/// faces, so that a closed mesh stays closed but for vertices that the file has twice. Errors: a texture that is no
/// float texture, a value that is not finite, more triangles than the budget.
Result<SceneShape> displaced_mesh(const SceneShape& shape, const Transform& placement, const TextureTable& textures);

}  // namespace raylex::transport
