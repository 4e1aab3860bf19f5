// A face of a mesh, with the data that all hits on it share.
#pragma once

#include <array>
#include <cstdint>

#include "transport/geometry/ray.h"
#include "transport/math/vec.h"

namespace raylex::transport {

/// Half a cache line (in float); a hit needs all of it.
struct alignas(32) Triangle {
    std::array<std::uint32_t, 3> corners;  ///< indices of vertices in Embree's buffer
    Vec3 normal;                           ///< unit, by the order of the corners, in the space of the stored vertices
    /// of all points on it, without the rounding of the point itself; see surface.cpp
    OffsetBound offset;
};

/// Computes `normal` and `offset` of a triangle whose area is not 0: place_mesh() drops the others.
Triangle make_triangle(const std::array<std::uint32_t, 3>& corners, const StoredVec3* positions);

}  // namespace raylex::transport
