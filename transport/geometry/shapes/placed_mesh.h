// Meshes where they are traced: from the space they were written in, in double, to the floats that Embree reads.
#pragma once

#include <cstdint>
#include <vector>

#include "lpe/result.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

struct PlacedMesh {
    std::vector<StoredVec3> positions, normals;  ///< normals not normalised; none where the shape has none
    std::vector<std::uint32_t> indices;
    std::size_t dropped = 0;  ///< faces that have no area in single precision where they stand, and are left out
};

/// Of a mesh whose numbers and indices check_mesh() has passed. Vertices go through `placement` in double and are then
/// rounded; normals through its inverse transpose. Errors: a placement without inverse, a vertex or normal that leaves
/// the range of float.
Result<PlacedMesh> place_mesh(const SceneShape& shape, const Transform& placement);

/// Removes the faces whose area is exactly 0 from `indices` (3 a triangle, 4 a patch); returns how many.
std::size_t drop_faces_without_area(ShapeKind kind, const std::vector<StoredVec3>& positions,
                                    std::vector<std::uint32_t>& indices);

/// A mesh as warnings call it: by its file, if it is from one.
std::string mesh_name(const SceneShape& shape);

}  // namespace raylex::transport
