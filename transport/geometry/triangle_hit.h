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
    // Two at a time: (direction x e2, s x e1), and what each is multiplied by. Bit for bit what one at a time gives.
    using Pair = double __attribute__((vector_size(16)));
    const Pair ax{direction.x, s.x}, ay{direction.y, s.y}, az{direction.z, s.z};
    const Pair bx{e2.x, e1.x}, by{e2.y, e1.y}, bz{e2.z, e1.z};
    const Pair px = ay * bz - az * by, py = az * bx - ax * bz, pz = ax * by - ay * bx;
    const Pair with_edges = Pair{e1.x, e2.x} * px + Pair{e1.y, e2.y} * py + Pair{e1.z, e2.z} * pz;
    const Pair with_ray = Pair{s.x, direction.x} * px + Pair{s.y, direction.y} * py + Pair{s.z, direction.z} * pz;
    const double inverse = 1 / with_edges[0];
    TriangleHit hit{with_edges[1] * inverse, with_ray[0] * inverse, with_ray[1] * inverse};
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

/// Moves a hit inwards until it is `distance` away from each of the triangle's edges, where the triangle has room for
/// that: rounding must not carry the point across a neighbouring face, from behind which a leaving ray would never come
/// back (a closed room loses what leaves within an ulp of its edges). One hit in 40 is near enough for more than a
/// comparison; triangles that are less than 2^8 such distances wide may keep less.
template <class Distance>
void keep_off_edges(TriangleHit& hit, const DVec3& p0, const DVec3& p1, const DVec3& p2, const Distance& distance) {
    const double b0 = 1 - hit.u - hit.v;
    if (std::min({b0, hit.u, hit.v}) > 0x1p-8) [[likely]]
        return;
    // A weight b_i is the distance from edge E_i, opposite p_i, by |E_i| / (2 area); its gradient along the inward
    // normal of E_j is E_i . E_j / (2 area |E_j|).
    const DVec3 edges[3] = {p2 - p1, p0 - p2, p1 - p0};
    const double doubled_area = length(cross(edges[2], edges[1])), off = distance(), old[3] = {b0, hit.u, hit.v};
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
