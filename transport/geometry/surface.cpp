// From hits to surface points: positions, normals and parameterisation by pbrt-v4's conventions ("Physically Based
// Rendering", 4th edition, chapter 6), and the bound on where the intersector may think the surface is.
//
// The bound for a triangle. The point is v0 + b1 e1 + b2 e2 in double, rounded once: each coordinate is off by u |p|,
// u = 2^-24, and so is the origin made from it, which offset_ray_origin() makes up for. Embree's robust test (Pluecker
// coordinates) moves the vertices to the ray's origin o: each coordinate is off by u |v - o| <= u extent. The plane
// through vertices moved so passes o at most n . u extent aside, o being a mean of them, and its edges a_i are off by
// 2 u extent. It takes N as the cross product of two edges (2 roundings a product, 1 for the difference:
// gamma(3) (|a_i b_j| + |a_j b_i|)) and evaluates (v0 - o) . N (gamma(3)). The distance it sees is thus off by at most
//   gamma(2) |n| . |p| + gamma(8) ((a x+ b) . extent) / |N|,  x+ the cross product with plus signs,
// with 2 u extent added to each edge: it is that term which keeps slivers behind the ray that leaves them. Which two of
// the edges, it chooses for each component by the smaller of two products (products_of_normal() does the same), so that
// a sliver's short edge is one of them: two long ones would make the bound a multiple of the sliver itself.
// Componentwise bounds keep axis-aligned planes nearly exact. A plane through 0 would get 0, so 2^-32 of the triangle's
// extent is added: it changes nothing elsewhere.
#include "display/services/elementary.h"
#include "transport/geometry/embree_scene.h"
#include "transport/geometry/vec3_pair.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace raylex::transport {
namespace {

constexpr Vec3 absolute(const Vec3& v) {
    return {v.x < 0 ? -v.x : v.x, v.y < 0 ? -v.y : v.y, v.z < 0 ? -v.z : v.z};
}
constexpr Vec3 largest(const Vec3& a, const Vec3& b) {
    return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}
constexpr Vec3 smallest(const Vec3& a, const Vec3& b) {
    return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}

/// Shading normal from vertex normals, and the geometric normal turned to its side, as pbrt does.
void apply_vertex_normal(const Vec3& interpolated, SurfacePoint& point) {
    const Real l2 = length_squared(interpolated);
    if (!(l2 > 0)) return;
    point.shading_normal = interpolated / std::sqrt(l2);
    point.geometric_normal = face_forward(point.geometric_normal, point.shading_normal);
}

/// Sums of the magnitudes of the products that Embree's stable_triangle_normal(a, b, c) makes a normal of; where its
/// choice is closer than rounding decides, the larger.
Vec3 products_of_normal(const Vec3& a, const Vec3& b, const Vec3& c) {
    const auto chosen = [](Real ab, Real ab_other, Real bc, Real bc_other) {
        const Real of_ab = ab + ab_other, of_bc = bc + bc_other;
        return 2 * ab < bc ? of_ab : 2 * bc < ab ? of_bc : std::max(of_ab, of_bc);
    };
    return {chosen(a.z * b.y, a.y * b.z, b.z * c.y, b.y * c.z), chosen(a.x * b.z, a.z * b.x, b.x * c.z, b.z * c.x),
            chosen(a.y * b.x, a.x * b.y, b.y * c.x, b.x * c.y)};
}

/// What is asked in double of a hit on a triangle.
struct TrianglePoint {
    Vec3 position, normal;  ///< the unit normal that the vertices' order gives
    Real inverse_length;    ///< of the cross product of its edges
};

/// Of two hits. In double: differences of floats and products of those are next to exact there, so slivers keep their
/// normal, and the length of the cross product of edges of 1e-10 does not drown (its square is below the smallest
/// float).
std::array<TrianglePoint, 2> triangle_points(const std::array<const ShapeGeometry*, 2>& shapes,
                                             const std::array<const Hit*, 2>& hits) {
    const auto both = [&](int number) {
        const auto corner = [&](std::size_t k) -> const StoredVec3& {
            return shapes[k]->positions[shapes[k]->indices[3 * static_cast<std::size_t>(hits[k]->primitive) + number]];
        };
        return DVec3Pair::of(corner(0), corner(1));
    };
    const DVec3Pair from = both(0), along1 = both(1) - from, along2 = both(2) - from;
    const DVec3Pair position =
        from + along1 * DoublePair{hits[0]->u, hits[1]->u} + along2 * DoublePair{hits[0]->v, hits[1]->v};
    const DVec3Pair n = cross(along1, along2);
    const DoublePair squared = dot(n, n);
    const DoublePair inverse = 1 / DoublePair{std::sqrt(squared[0]), std::sqrt(squared[1])};
    const DVec3Pair unit = n * inverse;
    const auto point = [&](int k) {
        return TrianglePoint{position[k].to_real(), unit[k].to_real(), static_cast<Real>(inverse[k])};
    };
    return {point(0), point(1)};
}

void triangle_surface(const ShapeGeometry& shape, const Hit& hit, const TrianglePoint& found, SurfacePoint& point,
                      OffsetBound& offset) {
    const std::uint32_t* index = shape.indices + 3 * static_cast<std::size_t>(hit.primitive);
    const Vec3 p0 = shape.positions[index[0]], p1 = shape.positions[index[1]], p2 = shape.positions[index[2]];
    const Real b1 = hit.u, b2 = hit.v, b0 = 1 - b1 - b2;
    const Vec3 e1 = p1 - p0, e2 = p2 - p0;
    const Vec3& unflipped = found.normal;
    const Real inverse_length = found.inverse_length;
    point.position = found.position;
    point.geometric_normal = shape.flip_normal ? -unflipped : unflipped;

    const Vec3 top = largest(p0, largest(p1, p2)), bottom = smallest(p0, smallest(p1, p2));
    const Vec3 extent = top - bottom, moved = extent * (2 * unit_roundoff);
    const Vec3 a1 = absolute(e1) + moved, a2 = absolute(e2) + moved;
    // The sums of one pair bound those of the other that Embree may prefer by three times: |b_i c_j| of what it
    // compares is the smaller, and the other product differs from it by N. 3 x 3 + 3 + 1 roundings then, for 8.
    Vec3 products = Vec3{a1.y * a2.z + a1.z * a2.y, a1.z * a2.x + a1.x * a2.z, a1.x * a2.y + a1.y * a2.x} * 1.625f;
    const Real spread = (products.x + products.y + products.z) * inverse_length;
    if (spread > 16) [[unlikely]]  // a sliver
        products = products_of_normal(a2, a1, absolute(p1 - p2) + moved);
    offset.per_distance = offset_per_distance(spread);
    offset.here = gamma_bound(2) * dot(absolute(point.geometric_normal), absolute(point.position)) +
                  gamma_bound(8) * dot(products * inverse_length, extent) + 0x1p-32f * (extent.x + extent.y + extent.z);

    point.shading_normal = point.geometric_normal;
    if (!shape.normals.empty()) {
        point.geometric_normal = point.shading_normal = unflipped;  // pbrt ignores the flip where vertex normals decide
        apply_vertex_normal(Vec3(shape.normals[index[0]]) * b0 + Vec3(shape.normals[index[1]]) * b1 +
                                Vec3(shape.normals[index[2]]) * b2,
                            point);
    }
    if (shape.uvs.empty()) {
        point.u = b1 + b2;  // default uvs (0,0), (1,0), (1,1)
        point.v = b2;
        point.dpdu = e1;
        return;
    }
    const Vec2 t0 = shape.uvs[index[0]], t1 = shape.uvs[index[1]], t2 = shape.uvs[index[2]];
    point.u = t0.x * b0 + t1.x * b1 + t2.x * b2;
    point.v = t0.y * b0 + t1.y * b1 + t2.y * b2;
    const Vec2 d1{t1.x - t0.x, t1.y - t0.y}, d2{t2.x - t0.x, t2.y - t0.y};
    const Real determinant = d1.x * d2.y - d1.y * d2.x;
    point.dpdu = std::abs(determinant) < Real(1e-9) ? Frame::from_normal(point.geometric_normal).s
                                                    : (e1 * d2.y - e2 * d1.y) / determinant;
}

/// A ray in the space of the shape's definition, in double.
struct LocalRay {
    DVec3 origin, direction;
};

void quadric_surface(const Quadric& q, const LocalRay& ray, const Hit& hit, SurfacePoint& point, OffsetBound& offset) {
    // t is a float, so the point is put back on the surface, in double; what moves is only along the ray.
    DVec3 p = q.placement.to_object.point(ray.origin + ray.direction * hit.t);
    if (q.kind == ShapeKind::sphere) {
        p = p * (q.radius / length(p));
    } else if (q.kind == ShapeKind::cylinder) {
        const double scale = q.radius / elementary::hypot(p.x, p.y);
        p = {p.x * scale, p.y * scale, p.z};
    } else {
        p.z = q.height;
    }
    const DVec3 n = normalize(q.placement.to_object.normal_of_inverse(q.object_normal(p)));
    point.position = q.placement.to_world.point(p).to_real();
    point.geometric_normal = point.shading_normal = q.reversed ? -n.to_real() : n.to_real();
    point.dpdu = q.placement.to_world.vector(q.object_dpdu(p)).to_real();
    point.u = hit.u;
    point.v = hit.v;
    // One rounding to float each for the point and for the origin made from it; the intersection itself is in double.
    offset = {gamma_bound(3) * dot(absolute(point.geometric_normal), absolute(point.position)) +
                  static_cast<Real>(1e-13 * q.extent()),
              offset_per_distance(1)};
}

void patch_surface(const ShapeGeometry& shape, const Hit& hit, SurfacePoint& point, OffsetBound& offset) {
    const BilinearPatch patch = shape.patch(hit.primitive);
    const double u = hit.u, v = hit.v;
    const DVec3 dpdu = patch.dpdu(v), dpdv = patch.dpdv(u);
    point.position = patch.point(u, v).to_real();
    Vec3 n = normalize(cross(dpdu, dpdv)).to_real();
    if (!is_finite(n)) n = normalize(cross(patch.p10 - patch.p00, patch.p01 - patch.p00)).to_real();
    if (shape.flip_normal) n = -n;
    point.geometric_normal = point.shading_normal = n;
    point.dpdu = dpdu.to_real();
    point.u = hit.u;
    point.v = hit.v;
    const std::uint32_t* index = shape.patch_indices.data() + 4 * static_cast<std::size_t>(hit.primitive);
    const Real w00 = (1 - hit.u) * (1 - hit.v), w10 = hit.u * (1 - hit.v), w01 = (1 - hit.u) * hit.v,
               w11 = hit.u * hit.v;
    if (!shape.uvs.empty()) {
        const Vec2 t00 = shape.uvs[index[0]], t10 = shape.uvs[index[1]], t01 = shape.uvs[index[2]],
                   t11 = shape.uvs[index[3]];
        point.u = t00.x * w00 + t10.x * w10 + t01.x * w01 + t11.x * w11;
        point.v = t00.y * w00 + t10.y * w10 + t01.y * w01 + t11.y * w11;
        // dp/ds by the chain rule from dp/d(u,v) and the inverse of d(s,t)/d(u,v).
        const double su = (t10.x - t00.x) * (1 - v) + (t11.x - t01.x) * v,
                     sv = (t01.x - t00.x) * (1 - u) + (t11.x - t10.x) * u;
        const double tu = (t10.y - t00.y) * (1 - v) + (t11.y - t01.y) * v,
                     tv = (t01.y - t00.y) * (1 - u) + (t11.y - t10.y) * u;
        const double determinant = su * tv - sv * tu;
        if (determinant != 0) point.dpdu = ((dpdu * tv - dpdv * tu) * (1 / determinant)).to_real();
    }
    if (!shape.normals.empty()) {
        if (shape.flip_normal) point.geometric_normal = -n;
        apply_vertex_normal(Vec3(shape.normals[index[0]]) * w00 + Vec3(shape.normals[index[1]]) * w10 +
                                Vec3(shape.normals[index[2]]) * w01 + Vec3(shape.normals[index[3]]) * w11,
                            point);
    }
    Vec3 reach;
    for (int i = 0; i < 4; ++i) reach = largest(reach, absolute(shape.patch_positions[index[i]]));
    offset = {gamma_bound(3) * dot(absolute(n), absolute(point.position)) + Real(1e-13) * (reach.x + reach.y + reach.z),
              offset_per_distance(1)};
}

/// Takes a point from its object's space to the world. Embree brings rays there in float: that rounding, seen along the
/// normal, joins the bound, and both scale with the transform.
void place(const Placement& placement, SurfacePoint& point, OffsetBound& offset) {
    const DVec3 local_normal(point.geometric_normal);
    const DVec3 world = placement.to_world.point(DVec3(point.position));
    const DVec3 normal = placement.to_object.normal_of_inverse(local_normal);
    const double stretch = length(normal);  // of distances along the normal, inverted
    double rounding = 0, turned = 0;
    const double axis[3] = {std::abs(local_normal.x), std::abs(local_normal.y), std::abs(local_normal.z)};
    for (int r = 0; r < 3; ++r) {
        const double* row = placement.to_object.m[r];
        rounding += axis[r] * (std::abs(row[0] * world.x) + std::abs(row[1] * world.y) + std::abs(row[2] * world.z) +
                               std::abs(row[3]));
        turned += axis[r] * (std::abs(row[0]) + std::abs(row[1]) + std::abs(row[2]));
    }
    const DVec3 shading = normalize(placement.to_object.normal_of_inverse(DVec3(point.shading_normal)));
    point.position = world.to_real();
    point.geometric_normal = (normal * (1 / stretch)).to_real();
    point.shading_normal = shading.to_real();
    point.dpdu = placement.to_world.vector(DVec3(point.dpdu)).to_real();
    // 6: the inverse's own rounding to float, the product's three terms and the sum. A ray from afar has coordinates
    // that are larger by the distance: 6 u `turned` a unit of it, of 16 u.
    offset.here = static_cast<Real>((offset.here + gamma_bound(6) * rounding) / stretch) +
                  gamma_bound(3) * dot(absolute(point.geometric_normal), absolute(point.position));
    offset.per_distance = offset_per_distance(offset.per_distance * 0x1p20f + static_cast<Real>(turned / stretch));
}

}  // namespace

void EmbreeScene::surfaces(std::span<const Ray> rays, std::span<const Hit> hits, std::span<SurfacePoint> points,
                           std::span<SurfaceSource> sources) const {
    const auto is_triangle = [&](std::size_t i) { return shapes_[hits[i].shape].kind == ShapeKind::triangle_mesh; };
    std::array<TrianglePoint, 2> triangles{};
    bool next_is_known = false;  // triangles[1] is the next hit's
    for (std::size_t i = 0; i < hits.size(); ++i) {
        const Hit& hit = hits[i];
        const ShapeGeometry& shape = shapes_[hit.shape];
        SurfacePoint& point = points[i];
        SurfaceSource& source = sources[i];
        const bool instanced = hit.instance != Hit::none;
        if (shape.kind == ShapeKind::triangle_mesh) {
            if (next_is_known) {
                next_is_known = false;
                triangles[0] = triangles[1];
            } else {
                next_is_known = i + 1 < hits.size() && is_triangle(i + 1);
                const Hit& other = hits[next_is_known ? i + 1 : i];
                triangles = triangle_points({&shape, &shapes_[other.shape]}, {&hit, &other});
            }
            triangle_surface(shape, hit, triangles[0], point, source.offset);
        } else if (shape.kind == ShapeKind::bilinear_mesh) {
            patch_surface(shape, hit, point, source.offset);
        } else {
            LocalRay ray{DVec3(rays[i].origin), DVec3(rays[i].direction)};
            if (instanced) {
                const Matrix34& inverse = instances_[hit.instance].placement.to_object;
                ray = {inverse.point(ray.origin), inverse.vector(ray.direction)};
            }
            quadric_surface(shape.quadric, ray, hit, point, source.offset);
        }
        source.label = shape.label;
        source.object_id = static_cast<std::int32_t>(hit.shape) + 1;
        if (instanced) {
            const ShapeInstance& instance = instances_[hit.instance];
            place(instance.placement, point, source.offset);
            if (instance.label >= 0) source.label = instance.label;
            source.object_id = static_cast<std::int32_t>(top_level_shapes_ + hit.instance) + 1;
        }
        point.wo = -rays[i].direction;
        point.material = shape.material;
    }
}

}  // namespace raylex::transport
