// Where a ray meets a triangle that the intersector says it hits.
//
// Embree divides by approximate reciprocals, whose last bits are the processor maker's. Only which primitive was hit is
// taken from it: where, is computed here from the ray and the stored vertices, in double, so that it depends on nothing
// else.
#pragma once

#include <algorithm>

#include "transport/geometry/matrix34.h"

namespace raylex::transport {

struct TriangleHit {
    double t = 0, u = 0, v = 0;  ///< u, v >= 0, u + v <= 1: weights of p1 and p2
};

/// By Moeller and Trumbore 1997, "Fast, minimum storage ray/triangle intersection", section 2. Differences of floats
/// and products of those are nearly exact in double: where the ray meets the triangle in the numbers given, u, v and t
/// are good to 2^-24 down to an angle of 2^-24 between ray and plane. Where it only meets it by the intersector's
/// rounding, or runs in its plane, the point is the triangle's nearest in (u, v), and t the ray's distance to there.
inline TriangleHit meet_triangle(const DVec3& origin, const DVec3& direction, const DVec3& p0, const DVec3& p1,
                                 const DVec3& p2) {
    const DVec3 e1 = p1 - p0, e2 = p2 - p0, s = origin - p0;
    const DVec3 p = cross(direction, e2), q = cross(s, e1);
    const double inverse = 1 / dot(e1, p);
    TriangleHit hit{dot(e2, q) * inverse, dot(s, p) * inverse, dot(direction, q) * inverse};
    if ((hit.u >= 0) & (hit.v >= 0) & (hit.u + hit.v <= 1)) [[likely]]
        return hit;
    const auto unit = [](double x) { return x > 0 ? std::min(x, 1.0) : 0.0; };  // 0 for what is no number
    hit.u = unit(hit.u);
    hit.v = unit(hit.v);
    if (const double sum = hit.u + hit.v; sum > 1) {
        hit.u /= sum;
        hit.v /= sum;
    }
    hit.t = dot(e1 * hit.u + e2 * hit.v - s, direction) / dot(direction, direction);
    return hit;
}

}  // namespace raylex::transport
