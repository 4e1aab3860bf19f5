// Loop's subdivision of triangle meshes.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lpe/result.h"
#include "transport/import/shapes/shapes.h"

namespace raylex::transport {

using MeshFace = std::array<std::uint32_t, 3>;

struct SubdividedMesh {
    std::vector<StoredVec3> positions;   ///< on the limit surface
    std::vector<StoredVec3> normals;     ///< unit normals of the limit surface
    std::vector<std::uint32_t> indices;  ///< 3 per triangle
    std::size_t odd_edges = 0;           ///< of more than two faces, or of two with opposite orientations
};

/// Splits each triangle into four `levels` times, then moves every vertex to its limit position. Vertices that no face
/// uses are omitted. Errors, at `where`: a face with a repeated corner, more triangles than the budget.
Result<SubdividedMesh> loop_subdivision(const std::vector<StoredVec3>& positions, const std::vector<MeshFace>& faces,
                                        int levels, const SourceLocation& where);

/// Makes the triangles of pbrt's `loopsubdiv`.
Result<std::vector<SceneShape>> make_loop_subdivision(const ParameterSet& parameters, const ShapeContext& context,
                                                      std::vector<Error>& warnings);

}  // namespace raylex::transport
