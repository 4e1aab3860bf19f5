// Polygon files (PLY 1.0): ASCII, binary of either byte order, gzip-compressed or not.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lpe/result.h"
#include "transport/math/vec.h"

namespace raylex::transport {

/// A polygon mesh with indices in range. As in pbrt-v4, quadrilaterals are bilinear patches, and there are no other
/// polygons.
struct PlyMesh {
    std::vector<StoredVec3> positions, normals;  ///< normals: one per position, or none; some may not be finite
    std::vector<StoredVec2> uvs;                 ///< one per position, or none
    std::vector<std::uint32_t> triangles;        ///< 3 per triangle
    std::vector<std::uint32_t> quads;            ///< 4 per quadrilateral, p00 p10 p01 p11
    /// vertices whose texture coordinates were not finite and were set to 0
    std::size_t broken_uvs = 0;
    std::size_t odd_faces = 0;  ///< faces with neither 3 nor 4 vertices, which are omitted
};

/// Reads the vertex element (x y z, nx ny nz, and texture coordinates as u v, s t, texture_u texture_v or texture_s
/// texture_t) and the face element's list (vertex_indices or vertex_index); other elements and properties are skipped.
/// Errors name the file, what was found and what was expected, with the line of an ASCII file or the byte offset (in
/// the decompressed data) of a binary one: a header that does not parse, data that ends early, an index out of range, a
/// position that is not finite.
Result<PlyMesh> read_ply(const std::string& path);
/// Parses the content of a PLY file as read_ply() does; `path` is for messages.
Result<PlyMesh> parse_ply(const std::string& content, const std::string& path);

}  // namespace raylex::transport
