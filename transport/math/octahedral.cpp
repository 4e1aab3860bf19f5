#include "transport/math/octahedral.h"

#include <algorithm>
#include <cmath>

#include "display/services/elementary.h"
#include "transport/math/sampling.h"

namespace raylex::transport {

Vec2 octahedral_from_direction(const Vec3& d) {
    const Real x = std::abs(d.x), y = std::abs(d.y), z = std::abs(d.z);
    const Real r = safe_sqrt(1 - z);
    const Real a = std::max(x, y), b = std::min(x, y);
    Real phi = elementary::atan(a == 0 ? 0 : b / a) * (2 * inv_pi);
    if (x < y) phi = 1 - phi;
    Real v = phi * r, u = r - v;
    if (d.z < 0) {
        std::swap(u, v);
        u = 1 - u;
        v = 1 - v;
    }
    return {(std::copysign(u, d.x) + 1) * 0.5f, (std::copysign(v, d.y) + 1) * 0.5f};
}

Vec3 direction_from_octahedral(const Vec2& uv) {
    const Real u = 2 * uv.x - 1, v = 2 * uv.y - 1;
    const Real up = std::abs(u), vp = std::abs(v);
    const Real signed_distance = 1 - (up + vp);
    const Real r = 1 - std::abs(signed_distance);
    const Real phi = (r == 0 ? 1 : (vp - up) / r + 1) * (pi / 4);
    const Real z = std::copysign(1 - r * r, signed_distance);
    const Real s = r * safe_sqrt(2 - r * r);
    const auto [sine, cosine] = elementary::sin_cos(phi);
    return {std::copysign(cosine, u) * s, std::copysign(sine, v) * s, z};
}

}  // namespace raylex::transport
