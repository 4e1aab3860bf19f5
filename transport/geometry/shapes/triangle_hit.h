// The place at which a ray meets a triangle that the intersector found.
//
// Embree divides by approximate reciprocals, whose last bits depend on the processor's maker. Only the primitive is
// taken from Embree: the place is computed here from the ray and the stored vertices, in double, so that it depends on
// nothing else.
#pragma once

#include <algorithm>
#include <type_traits>

#include "transport/geometry/vec3_pair.h"

namespace raylex::transport {

template <class Number>
struct TriangleHit {
    Number t, u, v;  ///< u, v: weights of p1 and p2
};

/// The intersection of a ray with a triangle's plane, or of two rays with two planes (DVec3Pair), by Moeller and
/// Trumbore 1997, "Fast, minimum storage ray/triangle intersection", section 2. Differences of floats and their
/// products are nearly exact in double: u, v and t are good to 2^-24 down to an angle of 2^-24 between ray and plane.
template <class Vector>
auto meet_plane(const Vector& origin, const Vector& direction, const Vector& p0, const Vector& p1, const Vector& p2) {
    const Vector e1 = p1 - p0, e2 = p2 - p0, s = origin - p0;
    const Vector across_ray = cross(direction, e2), across_edge = cross(s, e1);
    const auto inverse = 1 / dot(e1, across_ray);
    return TriangleHit<std::remove_cv_t<decltype(inverse)>>{
        dot(e2, across_edge) * inverse, dot(s, across_ray) * inverse, dot(direction, across_edge) * inverse};
}

/// The place at which the ray meets the triangle: u, v >= 0, u + v <= 1. If the ray meets it only within the
/// intersector's rounding, or runs in its plane, the result is the triangle's nearest point in (u, v), and t is the
/// ray's distance to it.
inline TriangleHit<double> meet_triangle(const DVec3& origin, const DVec3& direction, const DVec3& p0, const DVec3& p1,
                                         const DVec3& p2) {
    TriangleHit<double> hit = meet_plane(origin, direction, p0, p1, p2);
    if ((hit.u >= 0) & (hit.v >= 0) & (hit.u + hit.v <= 1)) return hit;
    const auto unit = [](double x) { return x > 0 ? std::min(x, 1.0) : 0.0; };  // NaN becomes 0
    hit.u = unit(hit.u);
    hit.v = unit(hit.v);
    if (const double sum = hit.u + hit.v; sum > 1) {
        hit.u /= sum;
        hit.v /= sum;
    }
    hit.t = dot((p1 - p0) * hit.u + (p2 - p0) * hit.v - (origin - p0), direction) / dot(direction, direction);
    return hit;
}

/// A hit nearer to an edge than this share of the triangle may have to move; see keep_off_edges().
inline constexpr double near_edge = 0x1p-8;

/// Moves a hit inwards until it is `off` away from each edge, if the triangle is wide enough. Otherwise rounding could
/// carry the point across a neighbouring face, from behind which a leaving ray would never come back (a closed room
/// loses rays that leave within an ulp of its edges). Triangles narrower than 1 / near_edge such distances may keep a
/// smaller distance.
inline void keep_off_edges(TriangleHit<double>& hit, const DVec3& p0, const DVec3& p1, const DVec3& p2, double off) {
    const double b0 = 1 - hit.u - hit.v;
    if (std::min({b0, hit.u, hit.v}) > near_edge) return;
    // The weight b_i is the distance from edge E_i, opposite p_i, times |E_i| / (2 area). Its gradient along the inward
    // normal of E_j is E_i . E_j / (2 area |E_j|).
    const DVec3 edges[3] = {p2 - p1, p0 - p2, p1 - p0};
    const double doubled_area = length(cross(edges[2], edges[1])), old[3] = {b0, hit.u, hit.v};
    double moved[3] = {b0, hit.u, hit.v};
    for (int j = 0; j < 3; ++j) {
        const double along = length(edges[j]), by = off - old[j] * doubled_area / along;
        if (!(by > 0)) continue;
        for (int i = 0; i < 3; ++i) moved[i] += by * dot(edges[i], edges[j]) / (doubled_area * along);
    }
    if (!(std::min({moved[0], moved[1], moved[2]}) >= 0)) return;
    hit.u = moved[1];
    hit.v = moved[2];
}

}  // namespace raylex::transport
