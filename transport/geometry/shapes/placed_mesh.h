// Transforms meshes to the space in which they are traced, in double, and rounds them to the floats that Embree reads.
#pragma once

#include <cstdint>
#include <vector>

#include "lpe/result.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

struct PlacedMesh {
    std::vector<StoredVec3> positions, normals;  ///< normals: not normalised; empty if the shape has none
    std::vector<std::uint32_t> indices;
    std::size_t dropped = 0;  ///< faces that have no area in single precision at their place; they are omitted
};

/// Places a mesh that check_mesh() has accepted. Vertices are transformed by `placement` in double and then rounded;
/// normals are transformed by its inverse transpose. Errors: a placement without inverse, a vertex or normal beyond the
/// range of float.
Result<PlacedMesh> place_mesh(const SceneShape& shape, const Transform& placement);

/// Removes the faces whose area is exactly 0 from `indices` (3 per triangle, 4 per patch); returns their number.
std::size_t drop_faces_without_area(ShapeKind kind, const std::vector<StoredVec3>& positions,
                                    std::vector<std::uint32_t>& indices);

/// The name of a mesh in warnings: its file, if it has one.
std::string mesh_name(const SceneShape& shape);

}  // namespace raylex::transport
