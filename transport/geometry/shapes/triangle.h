// A face of a mesh, and what of a hit on it is the same wherever on it the hit is.
#pragma once

#include <array>
#include <cstdint>

#include "transport/geometry/ray.h"
#include "transport/math/vec.h"

namespace raylex::transport {

/// Half a cache line (in float), which a hit needs whole.
struct alignas(32) Triangle {
    std::array<std::uint32_t, 3> corners;  ///< numbers of vertices; where Embree reads them
    Vec3 normal;                           ///< unit, by the order of the corners, where they stand
    OffsetBound offset;                    ///< of points on it, but for what rounding those adds; see surface.cpp
};

/// Computes `normal` and `offset`. Of a triangle of some area: place_mesh() drops the others.
Triangle make_triangle(const std::array<std::uint32_t, 3>& corners, const StoredVec3* positions);

}  // namespace raylex::transport
