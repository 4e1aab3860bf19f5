// Maps the unit sphere to the unit square by way of an octahedron (E. Praun and H. Hoppe 2003, "Spherical
// Parametrization and Remeshing"). Areas change by up to 5.2 times, but no trigonometry is needed: guides map
// directions several times for each vertex of a path.
#pragma once

#include <cmath>

#include "transport/math/vec.h"

namespace raylex::transport {

/// Returns the point of the square, in [0, 1], of a unit direction.
inline Vec2 square_from_direction(const Vec3& direction) {
    const Real x = std::abs(direction.x), y = std::abs(direction.y);
    const Real scale = 1 / (x + y + std::abs(direction.z));
    const bool upper = direction.z >= 0;
    const Real u = upper ? x * scale : 1 - y * scale, v = upper ? y * scale : 1 - x * scale;
    return {Real(0.5) + std::copysign(Real(0.5) * u, direction.x),
            Real(0.5) + std::copysign(Real(0.5) * v, direction.y)};
}

/// Returns the unit direction of a point in [0, 1]^2.
inline Vec3 direction_from_square(const Vec2& at) {
    const Real u = 2 * at.x - 1, v = 2 * at.y - 1;
    const Real x = std::abs(u), y = std::abs(v), z = 1 - x - y;
    return normalize(Vec3{std::copysign(z >= 0 ? x : 1 - y, u), std::copysign(z >= 0 ? y : 1 - x, v), z});
}

/// Returns the area of the square per steradian, near a unit direction. Its integral over the sphere is 1.
inline Real square_per_steradian(const Vec3& direction) {
    const Real sum = std::abs(direction.x) + std::abs(direction.y) + std::abs(direction.z);
    return Real(0.25) / (sum * sum * sum);
}

}  // namespace raylex::transport
