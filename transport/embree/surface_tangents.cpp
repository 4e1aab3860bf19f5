// Tangents and the derivatives of normals, for bump and normal maps: Farin 2002, "Curves and Surfaces for CAGD",
// chapter 8. Vertex normals change tangents by pbrt-v4's conventions ("Physically Based Rendering", 4th edition,
// chapter 6): tangents of triangles are made orthogonal and equally long, those of patches are rotated.
#include "transport/embree/embree_scene.h"

#include <cmath>

namespace raylex::transport {
namespace {

/// Tangents in double, in the space of the shape.
struct LocalTangents {
    DVec3 dpdu, dpdv, dndu, dndv;
};

/// The derivative of a normalised normal: a normal of length `l` along `n` changes by `change`.
DVec3 turned(const DVec3& n, const DVec3& change, double l) {
    return l > 0 ? (change - n * dot(n, change)) * (1 / l) : DVec3();
}

/// The inverse of d(s,t)/d(a,b): converts derivatives along a and b to derivatives along the texture's s and t.
struct ChainRule {
    double sa = 1, sb = 0, ta = 0, tb = 1;

    [[nodiscard]] double determinant() const { return sa * tb - sb * ta; }
    void apply(DVec3& a, DVec3& b) const {
        const double inverse = 1 / determinant();
        const DVec3 s = (a * tb - b * ta) * inverse, t = (b * sa - a * sb) * inverse;
        a = s;
        b = t;
    }
};

LocalTangents any_tangents(const DVec3& n) {
    const Frame frame = Frame::from_normal(n.to_real());
    return {DVec3(frame.s), DVec3(frame.t), {}, {}};
}

LocalTangents triangle_tangents(const ShapeGeometry& shape, const Hit& hit) {
    const auto& index = shape.triangles[hit.primitive].corners;
    const auto at = [&](const auto& values, int i) { return DVec3(values[index[static_cast<std::size_t>(i)]]); };
    const DVec3 e1 = at(shape.positions, 1) - at(shape.positions, 0),
                e2 = at(shape.positions, 2) - at(shape.positions, 0);
    ChainRule rule{1, 1, 0, 1};  // default coordinates (0,0), (1,0), (1,1)
    if (!shape.uvs.empty()) {
        const StoredVec2 t0 = shape.uvs[index[0]], t1 = shape.uvs[index[1]], t2 = shape.uvs[index[2]];
        rule = {double{t1.x} - t0.x, double{t2.x} - t0.x, double{t1.y} - t0.y, double{t2.y} - t0.y};
    }
    const bool degenerate = std::abs(rule.determinant()) < 1e-9;
    LocalTangents result{e1, e2, {}, {}};
    if (degenerate) result = any_tangents(normalize(cross(e1, e2)));
    else rule.apply(result.dpdu, result.dpdv);
    if (shape.normals.empty()) return result;
    const DVec3 n0 = at(shape.normals, 0), d1 = at(shape.normals, 1) - n0, d2 = at(shape.normals, 2) - n0;
    const DVec3 normal = n0 + d1 * static_cast<double>(hit.u) + d2 * static_cast<double>(hit.v);
    const double l = length(normal);
    if (!(l > 0)) return result;
    const DVec3 n = normal * (1 / l);
    if (!degenerate) {
        result.dndu = turned(n, d1, l);
        result.dndv = turned(n, d2, l);
        rule.apply(result.dndu, result.dndv);
    }
    result.dpdv = cross(n, result.dpdu);
    result.dpdu = cross(result.dpdv, n);
    if (!(dot(result.dpdv, result.dpdv) > 0)) return any_tangents(n);
    return result;
}

/// Applies the smallest rotation that takes unit vector `from` to `to`, to v.
DVec3 rotate(const DVec3& from, const DVec3& to, const DVec3& v) {
    const DVec3 axis = cross(from, to);
    const double c = dot(from, to);
    if (!(c > -1)) return v;
    return v * c + cross(axis, v) + axis * (dot(axis, v) / (1 + c));
}

LocalTangents patch_tangents(const ShapeGeometry& shape, const Hit& hit) {
    const BilinearPatch patch = shape.patch(hit.primitive);
    const double u = hit.u, v = hit.v;
    LocalTangents result{patch.dpdu(v), patch.dpdv(u), {}, {}};
    const DVec3 normal = cross(result.dpdu, result.dpdv);
    const double l = length(normal), side = shape.flip_normal ? -1 : 1;
    const std::uint32_t* index = shape.patch_indices.data() + 4 * static_cast<std::size_t>(hit.primitive);
    if (shape.normals.empty()) {
        const DVec3 n = normal * (side / l);
        const DVec3 twist = (patch.p00 - patch.p10) - (patch.p01 - patch.p11);  // the only second derivative
        result.dndu = turned(n, cross(result.dpdu, twist) * side, l);
        result.dndv = turned(n, cross(twist, result.dpdv) * side, l);
    } else {
        const auto corner = [&](int i) { return DVec3(shape.normals[index[i]]); };  // 00, 10, 01, 11
        const BilinearPatch normals{corner(0), corner(1), corner(2), corner(3)};
        const DVec3 shading = normals.point(u, v);
        const double ls = length(shading);
        const DVec3 n = shading * (1 / ls);
        result.dndu = turned(n, normals.dpdu(v), ls);
        result.dndv = turned(n, normals.dpdv(u), ls);
        DVec3 plain = normal * (1 / l);
        if (dot(plain, n) < 0) plain = plain * -1;
        if (l > 0 && ls > 0) {
            result.dpdu = rotate(plain, n, result.dpdu);
            result.dpdv = rotate(plain, n, result.dpdv);
        }
    }
    if (shape.uvs.empty()) return result;
    const auto uv = [&](int i) { return DVec3{shape.uvs[index[i]].x, shape.uvs[index[i]].y, 0}; };
    const BilinearPatch coordinates{uv(0), uv(1), uv(2), uv(3)};
    const DVec3 along_u = coordinates.dpdu(v), along_v = coordinates.dpdv(u);
    const ChainRule rule{along_u.x, along_v.x, along_u.y, along_v.y};
    if (rule.determinant() == 0) return result;
    rule.apply(result.dpdu, result.dpdv);
    rule.apply(result.dndu, result.dndv);
    return result;
}

/// Tangents of a quadric; `instance` is null at the top level.
LocalTangents quadric_tangents(const Quadric& q, const Placement* instance, const Vec3& position) {
    const DVec3 world(position);
    const DVec3 p = q.placement.to_object.point(instance ? instance->to_object.point(world) : world);
    const DVec3 dpdu = q.object_dpdu(p), dpdv = q.object_dpdv(p), n = q.object_normal(p);
    LocalTangents result{q.placement.to_world.vector(dpdu), q.placement.to_world.vector(dpdv), {}, {}};
    if (q.kind == ShapeKind::disk) return result;
    // The normal is the gradient of (x^2 + y^2 [+ z^2]) / 2 over the radius.
    const double side = (q.reversed ? -1 : 1) / q.radius;
    const auto gradient = [&](const DVec3& d) { return DVec3{d.x, d.y, q.kind == ShapeKind::sphere ? d.z : 0} * side; };
    const DVec3 normal = q.placement.to_object.normal_of_inverse(n * (q.reversed ? -1 : 1));
    const double l = length(normal);
    result.dndu = turned(normal * (1 / l), q.placement.to_object.normal_of_inverse(gradient(dpdu)), l);
    result.dndv = turned(normal * (1 / l), q.placement.to_object.normal_of_inverse(gradient(dpdv)), l);
    return result;
}

}  // namespace

SurfaceTangents EmbreeScene::tangents(const Hit& hit, const SurfacePoint& point) const {
    const ShapeGeometry& shape = shapes_[hit.shape];
    // Heights are small compared with a fibre's radius, so the change of its normal is ignored.
    if (shape.kind == ShapeKind::curves) return {point.dpdu, details(hit, point).dpdv, {}, {}};
    std::optional<Placement> room;
    const Placement* const instance = placement_of(hit, room);
    LocalTangents local;
    if (shape.kind == ShapeKind::triangle_mesh) local = triangle_tangents(shape, hit);
    else if (shape.kind == ShapeKind::bilinear_mesh) local = patch_tangents(shape, hit);
    else local = quadric_tangents(shape.quadric, instance, point.position);
    if (instance != nullptr) {
        // World normals are M^-T n over their length. Up to length, n is M^T times the world normal.
        const DVec3 world(point.shading_normal);
        const Matrix34& m = instance->to_world;
        const DVec3 n = normalize(m.normal_of_inverse(world));
        const double l = length(instance->to_object.normal_of_inverse(n));
        for (DVec3* d : {&local.dpdu, &local.dpdv}) *d = m.vector(*d);
        for (DVec3* d : {&local.dndu, &local.dndv}) *d = turned(world, instance->to_object.normal_of_inverse(*d), l);
    }
    return {local.dpdu.to_real(), local.dpdv.to_real(), local.dndu.to_real(), local.dndv.to_real()};
}

}  // namespace raylex::transport
