// Hit data that only geometric AOVs need: the second derivative, object space, curvature, edges.
// || The mean curvature of a surface F(x) = 0 with gradient g and Hessian A is
//     H = (|g|^2 tr A - g.A g) / (2 |g|^3)
// seen from outside positive). For a parametric surface it follows from the fundamental forms, do Carmo 1976, section
// 3.3.
#include "transport/embree/embree_scene.h"

#include <cmath>

namespace raylex::transport {
namespace {

/// Mean curvature of a quadric in world space. The implicit equation is known in its own space: x_object =
/// Q(I(x_world)).
double quadric_curvature(const Quadric& q, const Matrix34& to_instance, const DVec3& p, const DVec3& view) {
    if (q.kind == ShapeKind::disk) return 0;
    const bool sphere = q.kind == ShapeKind::sphere;
    const auto hessian = [sphere](const DVec3& v) { return DVec3{v.x, v.y, sphere ? v.z : 0}; };
    const DVec3 gradient = hessian(p);  // of (x^2 + y^2 + z^2 - r^2) / 2, without z for cylinders
    const DVec3 unit[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    double world_gradient[3], trace = 0, square = 0;
    DVec3 along;
    for (int i = 0; i < 3; ++i) {
        const DVec3 column = q.placement.to_object.vector(to_instance.vector(unit[i]));
        world_gradient[i] = dot(column, gradient);
        trace += dot(column, hessian(column));
        along = along + column * world_gradient[i];
        square += world_gradient[i] * world_gradient[i];
    }
    const double h = (square * trace - dot(along, hessian(along))) / (2 * square * std::sqrt(square));
    return dot({world_gradient[0], world_gradient[1], world_gradient[2]}, view) < 0 ? -h : h;
}

/// The first fundamental form of tangents a and b.
struct Metric {
    double e, f, g, determinant;
    Metric(const DVec3& a, const DVec3& b) : e(dot(a, a)), f(dot(a, b)), g(dot(b, b)), determinant(e * g - f * f) {}
};

struct DetailBuilder {
    const ShapeGeometry& shape;
    const Hit& hit;
    const SurfacePoint& point;
    const Placement* instance;  // null at the top level
    SurfaceDetails& details;

    [[nodiscard]] DVec3 world_vector(const DVec3& v) const { return instance ? instance->to_world.vector(v) : v; }
    [[nodiscard]] DVec3 world_point(const DVec3& p) const { return instance ? instance->to_world.point(p) : p; }
    [[nodiscard]] DVec3 world_normal(const DVec3& n) const {
        return instance ? instance->to_object.normal_of_inverse(n) : n;
    }
    [[nodiscard]] DVec3 local_position() const {
        const DVec3 p(point.position);
        return instance ? instance->to_object.point(p) : p;
    }
    void add_edge(const DVec3& from, const DVec3& to) const {
        const auto at = static_cast<std::size_t>(2 * details.edge_count++);
        details.edges[at] = world_point(from).to_real();
        details.edges[at + 1] = world_point(to).to_real();
    }

    void quadric() const {
        const Quadric& q = shape.quadric;
        const DVec3 p = q.placement.to_object.point(local_position());
        details.object_position = p.to_real();
        details.dpdv = world_vector(q.placement.to_world.vector(q.object_dpdv(p))).to_real();
        const Matrix34 none;
        details.curvature =
            static_cast<Real>(quadric_curvature(q, instance ? instance->to_object : none, p, DVec3(point.wo)));
    }

    void curve() const {
        const CurveSegment segment = shape.curves.segment(hit.primitive);
        const Placement none, &place = instance ? *instance : none;
        const DVec3 direction = place.to_object.vector(DVec3(point.wo) * -1), p = local_position();
        const double h = hit.v, r = segment.radius(hit.u);
        const CurveFrame frame = curve_frame(segment, direction, hit.u, h, p);
        DVec3 dpdv = frame.across;
        if (shape.curves.type == CurveType::cylinder) {
            dpdv = cross(frame.along, frame.offset);  // around the tube, towards h = 1 where that is visible
            if (dot(dpdv, frame.across) < 0) dpdv = dpdv * -1;
            details.curvature =
                static_cast<Real>(0.5 / (r * length(place.to_world.vector(frame.across))) *
                                  (dot(place.to_object.normal_of_inverse(frame.offset), DVec3(point.wo)) < 0 ? -1 : 1));
        }
        details.dpdv = world_vector(dpdv * (shape.curves.mirrored ? -2 * r : 2 * r)).to_real();
    }

    void triangle() const {
        const auto& index = shape.triangles[hit.primitive].corners;
        const DVec3 p[3] = {DVec3(shape.positions[index[0]]), DVec3(shape.positions[index[1]]),
                            DVec3(shape.positions[index[2]])};
        for (int i = 0; i < 3; ++i) add_edge(p[i], p[(i + 1) % 3]);
        const DVec3 e1 = p[1] - p[0], e2 = p[2] - p[0];
        DVec3 dpdv = e2 - e1;  // default coordinates (0,0), (1,0), (1,1)
        if (!shape.uvs.empty()) {
            const Vec2 t0 = shape.uvs[index[0]], t1 = shape.uvs[index[1]], t2 = shape.uvs[index[2]];
            const Vec2 d1{t1.x - t0.x, t1.y - t0.y}, d2{t2.x - t0.x, t2.y - t0.y};
            const Real determinant = d1.x * d2.y - d1.y * d2.x;
            // As in dpdu, degenerate coordinates get an arbitrary tangent of the plane.
            dpdv = std::abs(determinant) < Real(1e-9) ? cross(normalize(cross(e1, e2)), normalize(e1))
                                                      : (e2 * d1.x - e1 * d2.x) * (1.0 / determinant);
        }
        details.dpdv = world_vector(dpdv).to_real();
        if (!shape.normals.empty()) details.curvature = static_cast<Real>(normals_curvature(index, e1, e2));
    }

    /// Mean curvature by the change of the interpolated normal: half the trace of the shape operator.
    [[nodiscard]] double normals_curvature(const std::array<std::uint32_t, 3>& index, const DVec3& e1,
                                           const DVec3& e2) const {
        const DVec3 n0 = world_normal(DVec3(shape.normals[index[0]])),
                    n1 = world_normal(DVec3(shape.normals[index[1]])),
                    n2 = world_normal(DVec3(shape.normals[index[2]]));
        const DVec3 d1 = n1 - n0, d2 = n2 - n0,
                    n = n0 + d1 * static_cast<double>(hit.u) + d2 * static_cast<double>(hit.v);
        const double l = length(n);
        const DVec3 a = world_vector(e1), b = world_vector(e2);
        const Metric metric(a, b);
        if (!(l > 0) || !(metric.determinant > 0)) return 0;
        const DVec3 unit = n * (1 / l);
        const DVec3 turn1 = (d1 - unit * dot(unit, d1)) * (1 / l), turn2 = (d2 - unit * dot(unit, d2)) * (1 / l);
        const double trace =
            metric.g * dot(a, turn1) - metric.f * (dot(a, turn2) + dot(b, turn1)) + metric.e * dot(b, turn2);
        const double h = 0.5 * trace / metric.determinant;
        return dot(unit, DVec3(point.wo)) < 0 ? -h : h;
    }

    void patch() const {
        const BilinearPatch patch = shape.patch(hit.primitive);
        add_edge(patch.p00, patch.p10);
        add_edge(patch.p01, patch.p11);
        add_edge(patch.p00, patch.p01);
        add_edge(patch.p10, patch.p11);
        const double u = hit.u, v = hit.v;
        const DVec3 dpdu = patch.dpdu(v), dpdv = patch.dpdv(u);
        details.dpdv = world_vector(dpdv).to_real();
        if (!shape.uvs.empty()) {
            const std::uint32_t* index = shape.patch_indices.data() + 4 * static_cast<std::size_t>(hit.primitive);
            const Vec2 t00 = shape.uvs[index[0]], t10 = shape.uvs[index[1]], t01 = shape.uvs[index[2]],
                       t11 = shape.uvs[index[3]];
            const double su = (t10.x - t00.x) * (1 - v) + (t11.x - t01.x) * v,
                         sv = (t01.x - t00.x) * (1 - u) + (t11.x - t10.x) * u;
            const double tu = (t10.y - t00.y) * (1 - v) + (t11.y - t01.y) * v,
                         tv = (t01.y - t00.y) * (1 - u) + (t11.y - t10.y) * u;
            const double determinant = su * tv - sv * tu;
            if (determinant != 0) details.dpdv = world_vector((dpdv * su - dpdu * sv) * (1 / determinant)).to_real();
        }
        const DVec3 a = world_vector(dpdu), b = world_vector(dpdv);
        const DVec3 twist = world_vector((patch.p00 - patch.p10) - (patch.p01 - patch.p11));
        const Metric metric(a, b);
        if (!(metric.determinant > 0)) return;
        const DVec3 n = cross(a, b) * (1 / std::sqrt(metric.determinant));
        const double h = dot(n, twist) * metric.f / metric.determinant;  // the other second derivatives are 0
        details.curvature = static_cast<Real>(dot(n, DVec3(point.wo)) < 0 ? -h : h);
    }
};

}  // namespace

SurfaceDetails EmbreeScene::details(const Hit& hit, const SurfacePoint& point) const {
    SurfaceDetails details;
    const ShapeGeometry& shape = shapes_[hit.shape];
    std::optional<Placement> room;
    const Placement* const instance = placement_of(hit, room);
    const DetailBuilder builder{shape, hit, point, instance, details};
    if (shape.kind == ShapeKind::triangle_mesh) builder.triangle();
    else if (shape.kind == ShapeKind::bilinear_mesh) builder.patch();
    else if (shape.kind == ShapeKind::curves) builder.curve();
    else builder.quadric();
    if (!shape.is_user() || shape.kind == ShapeKind::bilinear_mesh)
        details.object_position = shape.to_object.point(builder.local_position()).to_real();
    return details;
}

}  // namespace raylex::transport
