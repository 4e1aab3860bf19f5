// A bound on the distance between a point of a triangle and the plane that the intersector tests. The point is v0 + b1
// e1 + b2 e2 in double, rounded once: each coordinate is off by u |p|, u = 2^-24, and so is the origin made from it,
// for which offset_ray_origin() compensates. Embree's robust test (Pluecker coordinates) moves the vertices to the
// ray's origin o: each coordinate is off by u |v - o| <= u extent. The plane through the moved vertices misses o by at
// most n . u extent, o being a mean of them, and its edges a_i are off by 2 u extent. Embree computes N as the cross
// product of two edges (2 roundings a product, 1 for the difference: gamma(3) (|a_i b_j| + |a_j b_i|)) and evaluates
// (v0 - o) . N (gamma(3)). So its distance is off by at most
//   gamma(2) |n| . |p| + gamma(8) ((a x+ b) . extent) / |N|,  x+ the cross product with plus signs,
// with 2 u extent added to each edge: that term keeps slivers behind the ray that leaves them. For each component
// Embree chooses the two edges by the smaller of two products (products_of_normal() does the same), so that a sliver's
// short edge is one of them: two long ones would make the bound a multiple of the sliver itself. Componentwise bounds
// keep axis-aligned planes nearly exact. A plane through 0 would get 0, so 2^-32 of the triangle's extent is added,
// which is negligible elsewhere.
//
// The first term depends on the point; the others are computed here, once.
#include "transport/geometry/shapes/triangle.h"

#include <algorithm>

#include "transport/math/matrix34.h"

namespace raylex::transport {
namespace {

/// Sums of the magnitudes of the products from which Embree's stable_triangle_normal(a, b, c) makes a normal. Where its
/// choice depends on rounding, the larger sum.
Vec3 products_of_normal(const Vec3& a, const Vec3& b, const Vec3& c) {
    const auto chosen = [](Real ab, Real ab_other, Real bc, Real bc_other) {
        const Real of_ab = ab + ab_other, of_bc = bc + bc_other;
        return 2 * ab < bc ? of_ab : 2 * bc < ab ? of_bc : std::max(of_ab, of_bc);
    };
    return {chosen(a.z * b.y, a.y * b.z, b.z * c.y, b.y * c.z), chosen(a.x * b.z, a.z * b.x, b.x * c.z, b.z * c.x),
            chosen(a.y * b.x, a.x * b.y, b.y * c.x, b.x * c.y)};
}

}  // namespace

Triangle make_triangle(const std::array<std::uint32_t, 3>& corners, const StoredVec3* positions) {
    Triangle triangle{corners, {}, {}};
    const Vec3 p0 = positions[corners[0]], p1 = positions[corners[1]], p2 = positions[corners[2]];
    // In double, differences of floats and their products are almost exact, so slivers keep their normal, and the
    // length of the cross product of edges of 1e-10 does not underflow (its square is below the smallest float).
    const DVec3 from(p0);
    const DVec3 n = cross(DVec3(p1) - from, DVec3(p2) - from);
    const double inverse = 1 / length(n);
    triangle.normal = (n * inverse).to_real();
    const Real inverse_length = static_cast<Real>(inverse);

    const Vec3 extent = largest(p0, largest(p1, p2)) - smallest(p0, smallest(p1, p2)),
               moved = extent * (2 * unit_roundoff);
    const Vec3 a1 = absolute(p1 - p0) + moved, a2 = absolute(p2 - p0) + moved;
    // The sums of one pair are at most a third of those of another pair that Embree may prefer: |b_i c_j| is the
    // smaller of the products that it compares, and the other product differs from it by N. That makes 3 x 3 + 3 + 1
    // roundings instead of 8.
    Vec3 products = Vec3{a1.y * a2.z + a1.z * a2.y, a1.z * a2.x + a1.x * a2.z, a1.x * a2.y + a1.y * a2.x} * 1.625f;
    const Real spread = (products.x + products.y + products.z) * inverse_length;
    if (spread > 16)  // a sliver
        products = products_of_normal(a2, a1, absolute(p1 - p2) + moved);
    triangle.offset = {
        gamma_bound(8) * dot(products * inverse_length, extent) + 0x1p-32f * (extent.x + extent.y + extent.z),
        offset_per_distance(spread)};
    return triangle;
}

}  // namespace raylex::transport
