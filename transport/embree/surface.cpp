// From hits to surface points: positions, normals and parameterisation by pbrt-v4's conventions ("Physically Based
// Rendering", 4th edition, chapter 6), and the bound on the distance between the point and the surface that the
// intersector tests (derived in triangle.cpp).
#include "display/services/elementary.h"
#include "transport/embree/embree_scene.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace raylex::transport {
namespace {

/// Interpolates the shading normal of vertex normals and turns the geometric normal to its side, as pbrt does.
void apply_vertex_normal(const Vec3& interpolated, SurfacePoint& point) {
    const Real l2 = length_squared(interpolated);
    if (!(l2 > 0)) return;
    point.shading_normal = interpolated / std::sqrt(l2);
    point.geometric_normal = face_forward(point.geometric_normal, point.shading_normal);
}

Vec2 triangle_coordinates(const ShapeGeometry& shape, const std::uint32_t* index, Real b1, Real b2) {
    if (shape.uvs.empty()) return {b1 + b2, b2};  // default uvs (0,0), (1,0), (1,1)
    const Real b0 = 1 - b1 - b2;
    const Vec2 t0 = shape.uvs[index[0]], t1 = shape.uvs[index[1]], t2 = shape.uvs[index[2]];
    return {t0.x * b0 + t1.x * b1 + t2.x * b2, t0.y * b0 + t1.y * b1 + t2.y * b2};
}

Vec2 patch_coordinates(const ShapeGeometry& shape, const std::uint32_t* index, Real u, Real v) {
    if (shape.uvs.empty()) return {u, v};
    const Real w00 = (1 - u) * (1 - v), w10 = u * (1 - v), w01 = (1 - u) * v, w11 = u * v;
    const Vec2 t00 = shape.uvs[index[0]], t10 = shape.uvs[index[1]], t01 = shape.uvs[index[2]],
               t11 = shape.uvs[index[3]];
    return {t00.x * w00 + t10.x * w10 + t01.x * w01 + t11.x * w11,
            t00.y * w00 + t10.y * w10 + t01.y * w01 + t11.y * w11};
}

void triangle_surface(const ShapeGeometry& shape, const Hit& hit, SurfacePoint& point, OffsetBound& offset) {
    const Triangle& triangle = shape.triangles[hit.primitive];
    const auto& index = triangle.corners;
    const Real b1 = hit.u, b2 = hit.v, b0 = 1 - b1 - b2;
    const DVec3 p0(shape.positions[index[0]]);
    const DVec3 e1 = DVec3(shape.positions[index[1]]) - p0, e2 = DVec3(shape.positions[index[2]]) - p0;
    point.position = (p0 + e1 * b1 + e2 * b2).to_real();
    point.geometric_normal = shape.flip_normal ? -triangle.normal : triangle.normal;
    offset = triangle.offset;
    offset.here += gamma_bound(2) * dot(absolute(point.geometric_normal), absolute(point.position));

    point.shading_normal = point.geometric_normal;
    if (!shape.normals.empty()) {
        point.geometric_normal = point.shading_normal =
            triangle.normal;  // pbrt ignores the flip if there are vertex normals
        apply_vertex_normal(Vec3(shape.normals[index[0]]) * b0 + Vec3(shape.normals[index[1]]) * b1 +
                                Vec3(shape.normals[index[2]]) * b2,
                            point);
    }
    const Vec2 at = triangle_coordinates(shape, index.data(), b1, b2);
    point.u = at.x;
    point.v = at.y;
    if (shape.uvs.empty()) {
        point.dpdu = e1.to_real();
        return;
    }
    const Vec2 t0 = shape.uvs[index[0]], t1 = shape.uvs[index[1]], t2 = shape.uvs[index[2]];
    const Vec2 d1{t1.x - t0.x, t1.y - t0.y}, d2{t2.x - t0.x, t2.y - t0.y};
    const Real determinant = d1.x * d2.y - d1.y * d2.x;
    point.dpdu = std::abs(determinant) < Real(1e-9) ? Frame::from_normal(point.geometric_normal).s
                                                    : (e1.to_real() * d2.y - e2.to_real() * d1.y) / determinant;
}

/// A ray in the space of the shape's definition, in double.
struct LocalRay {
    DVec3 origin, direction;
};

void quadric_surface(const Quadric& q, const LocalRay& ray, const Hit& hit, SurfacePoint& point, OffsetBound& offset) {
    // t is a float, so the point is projected back onto the surface, in double; the error remains along the ray only.
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
    offset = offset_of_rounded(point.geometric_normal, point.position, q.extent());
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
    const std::uint32_t* index = shape.patch_indices.data() + 4 * static_cast<std::size_t>(hit.primitive);
    const Real w00 = (1 - hit.u) * (1 - hit.v), w10 = hit.u * (1 - hit.v), w01 = (1 - hit.u) * hit.v,
               w11 = hit.u * hit.v;
    const Vec2 at = patch_coordinates(shape, index, hit.u, hit.v);
    point.u = at.x;
    point.v = at.y;
    if (!shape.uvs.empty()) {
        const Vec2 t00 = shape.uvs[index[0]], t10 = shape.uvs[index[1]], t01 = shape.uvs[index[2]],
                   t11 = shape.uvs[index[3]];
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
    offset = offset_of_rounded(n, point.position, patch.extent());
}

void curve_surface(const CurveBatch& curves, const LocalRay& ray, const Hit& hit, SurfacePoint& point,
                   OffsetBound& offset) {
    const CurveSegment segment = curves.segment(hit.primitive);
    const double u = hit.u, r = segment.radius(u);
    const CurveFrame frame = curve_frame(segment, ray.direction, u, hit.v, ray.origin + ray.direction * hit.t);
    point.position = (segment.point(u) + frame.offset * r).to_real();
    point.geometric_normal = point.shading_normal = curves.reversed ? -frame.normal.to_real() : frame.normal.to_real();
    point.dpdu = segment.tangent(u).to_real();
    point.u = hit.u;
    point.v = Real(0.5) + Real(0.5) * (curves.mirrored ? -hit.v : hit.v);
    point.mirrored = curves.mirrored;
    offset = offset_of_rounded(point.geometric_normal, point.position, curves.extent);
    offset.here += curve_offset(curves.type, static_cast<Real>(r));
}

/// Takes a point from its object's space to the world. Embree transforms rays to the object in float: that rounding
/// along the normal is added to the bound, and both scale with the transform. `growth` is
/// InstanceMotion::rounding_growth() for moving instances, else 1.
void place(const Placement& placement, double growth, SurfacePoint& point, OffsetBound& offset) {
    const DVec3 local_normal(point.geometric_normal);
    const DVec3 world = placement.to_world.point(DVec3(point.position));
    const DVec3 normal = placement.to_object.normal_of_inverse(local_normal);
    const double stretch = length(normal);  // of distances along the normal, by the inverse
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
    // 6: the rounding of the inverse to float, the product's three terms and the sum. Coordinates of a ray from afar
    // are larger by the distance: 6 u `turned` per unit of it, within the 16 u.
    offset.here = static_cast<Real>((offset.here + gamma_bound(6) * growth * rounding) / stretch) +
                  gamma_bound(3) * dot(absolute(point.geometric_normal), absolute(point.position));
    offset.per_distance =
        offset_per_distance(offset.per_distance * 0x1p20f + static_cast<Real>(growth * turned / stretch));
}

}  // namespace

Vec2 texture_coordinates(const ShapeGeometry& shape, std::uint32_t primitive, const Vec2& at) {
    if (shape.kind == ShapeKind::triangle_mesh)
        return triangle_coordinates(shape, shape.triangles[primitive].corners.data(), at.x, at.y);
    if (shape.kind == ShapeKind::bilinear_mesh)
        return patch_coordinates(shape, shape.patch_indices.data() + 4 * static_cast<std::size_t>(primitive), at.x,
                                 at.y);
    return at;  // quadrics: they are equal to u and v
}

void EmbreeScene::surfaces(std::span<const Ray> rays, std::span<const Hit> hits, std::span<SurfacePoint> points,
                           std::span<SurfaceSource> sources) const {
    std::optional<Placement> room;
    for (std::size_t i = 0; i < hits.size(); ++i) {
        const Hit& hit = hits[i];
        const ShapeGeometry& shape = shapes_[hit.shape];
        SurfacePoint& point = points[i];
        SurfaceSource& source = sources[i];
        const Placement* const placement = placement_of(hit, room);
        if (shape.kind == ShapeKind::triangle_mesh) {
            triangle_surface(shape, hit, point, source.offset);
        } else if (shape.kind == ShapeKind::bilinear_mesh) {
            patch_surface(shape, hit, point, source.offset);
        } else {
            LocalRay ray{DVec3(rays[i].origin), DVec3(rays[i].direction)};
            if (placement != nullptr)
                ray = {placement->to_object.point(ray.origin), placement->to_object.vector(ray.direction)};
            if (shape.kind == ShapeKind::curves) curve_surface(shape.curves, ray, hit, point, source.offset);
            else quadric_surface(shape.quadric, ray, hit, point, source.offset);
        }
        source.label = shape.label;
        source.object_id = static_cast<std::int32_t>(hit.shape) + 1;
        if (placement != nullptr) {
            const ShapeInstance& instance = instances_[hit.instance];
            const double growth = instance.motion < 0 ? 1 : InstanceMotion::rounding_growth(placement->to_world);
            place(*placement, growth, point, source.offset);
            if (shape.kind == ShapeKind::curves && placement->to_world.determinant() < 0)
                point.mirrored = !point.mirrored;
            if (instance.label >= 0) source.label = instance.label;
            source.object_id = static_cast<std::int32_t>(top_level_shapes_ + hit.instance) + 1;
        }
        point.wo = -rays[i].direction;
        point.material = shape.material;
        if (shape.kind != ShapeKind::curves) point.mirrored = false;
    }
}

}  // namespace raylex::transport
