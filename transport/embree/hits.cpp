// The place of a hit on the primitive that Embree found.
#include "transport/embree/embree_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "transport/geometry/shapes/triangle_hit.h"

namespace raylex::transport {

bool ShapeGeometry::intersect(unsigned primitive, const DVec3& origin, const DVec3& direction, const Interval& range,
                              double& t, double& u, double& v) const {
    if (kind == ShapeKind::bilinear_mesh)
        return patch(primitive).intersect(origin, direction, range.lower, range.upper, t, u, v);
    return quadric.intersect(origin, direction, range.lower, range.upper, t, u, v);
}

namespace {

void set_place(const Ray& ray, Hit& hit, double t, double u, double v) {
    hit.t = std::clamp(static_cast<Real>(t), Real(std::numeric_limits<float>::min()), ray.t_max);
    hit.u = static_cast<Real>(u);
    hit.v = static_cast<Real>(v);
    hit.cone = ray.cone.after(hit.t);
}

/// Replaces Embree's numbers by ours, unless the solver does not converge. Embree's v is h for flat curves, runs from 1
/// down to 0 for ribbons, and is undefined for tubes.
void finish_curve(const CurveSegment& segment, const DVec3& origin, const DVec3& direction, double t_max,
                  CurvePlace& place) {
    place.u = std::clamp(place.u, 0.0, 1.0);
    if (meet_curve(segment, origin, direction, t_max, place)) return;
    if (segment.type == CurveType::ribbon) place.h = 1 - 2 * place.h;
    if (segment.type == CurveType::cylinder) {
        const DVec3 p = origin + direction * place.t, across = curve_frame(segment, direction, place.u, 0, p).across;
        place.h = dot(p - segment.point(place.u), across) / segment.radius(place.u);
    }
    place.h = std::clamp(place.h, -1.0, 1.0);
}

/// The distance by which rounding may move a point, in the space of the shape's vertices: 4 units in the last place, at
/// the shape and, for an instance, in the world.
double rounding_at(const Placement* placement, const DVec3& point) {
    double reach = std::max({std::abs(point.x), std::abs(point.y), std::abs(point.z)});
    if (placement != nullptr) {
        const DVec3 world = placement->to_world.point(point);
        for (const auto& row : placement->to_object.m)
            reach += std::abs(row[0] * world.x) + std::abs(row[1] * world.y) + std::abs(row[2] * world.z);
    }
    return 0x1p-21 * reach;
}

}  // namespace

/// Computes the place of a hit that uses our ids.
void EmbreeScene::finish_hit(const Ray& ray, Hit& hit) const {
    DVec3 origin(ray.origin), direction(ray.direction);
    std::optional<Placement> room;
    const Placement* const placement = placement_of(hit, room);
    if (placement != nullptr) {
        origin = placement->to_object.point(origin);
        direction = placement->to_object.vector(direction);
    }
    const ShapeGeometry& shape = shapes_[hit.shape];
    if (shape.kind == ShapeKind::triangle_mesh) {
        const auto& index = shape.triangles[hit.primitive].corners;
        const DVec3 p0(shape.positions[index[0]]), p1(shape.positions[index[1]]), p2(shape.positions[index[2]]);
        const DVec3 e1 = p1 - p0, e2 = p2 - p0;
        TriangleHit found = meet_triangle(origin, direction, p0, p1, p2);
        // The rounding of the point and of its weights to single precision.
        keep_off_edges(found, p0, p1, p2,
                       rounding_at(placement, p0 + e1 * found.u + e2 * found.v) + 0x1p-23 * (length(e1) + length(e2)));
        set_place(ray, hit, found.t, found.u, found.v);
        return;
    }
    if (shape.kind == ShapeKind::curves) {
        CurvePlace place{hit.t, shape.curves.along(hit.primitive, hit.u), hit.v};
        finish_curve(shape.curves.segment(hit.primitive), origin, direction, ray.t_max, place);
        set_place(ray, hit, place.t, place.u, place.h);
        return;
    }
    // At the top level in float, this repeats what Embree's callback computed from the same numbers.
    if (double t, u, v; (hit.instance != Hit::none || real_is_double) &&
                        shape.intersect(hit.primitive, origin, direction, {0, ray.t_max}, t, u, v)) {
        hit.t = static_cast<Real>(t);
        hit.u = static_cast<Real>(u);
        hit.v = static_cast<Real>(v);
    }
    hit.cone = ray.cone.after(hit.t);
}

/// Computes two hits on triangles outside instances, which are most of a render's hits, with the same bits as
/// finish_hit().
void EmbreeScene::finish_triangles(const std::array<const Ray*, 2>& rays, const std::array<Hit*, 2>& hits) const {
    const auto corners = [&](std::size_t number) {
        const auto one = [&](const Hit& hit) -> const StoredVec3& {
            const ShapeGeometry& shape = shapes_[hit.shape];
            return shape.positions[shape.triangles[hit.primitive].corners[number]];
        };
        return DVec3Pair::of(one(*hits[0]), one(*hits[1]));
    };
    const auto found =
        meet_plane(DVec3Pair::of(rays[0]->origin, rays[1]->origin),
                   DVec3Pair::of(rays[0]->direction, rays[1]->direction), corners(0), corners(1), corners(2));
    for (int k = 0; k < 2; ++k) {
        const Ray& ray = *rays[static_cast<std::size_t>(k)];
        Hit& hit = *hits[static_cast<std::size_t>(k)];
        const double u = found.u[k], v = found.v[k], b0 = 1 - u - v;
        if (std::min({b0, u, v}) > near_edge) [[likely]]
            set_place(ray, hit, found.t[k], u, v);
        else finish_hit(ray, hit);  // one in 40
    }
}

/// Replaces Embree's ids by ours and computes the place of each hit anew, from the ray and the primitive alone. Images
/// depend on Embree only through the primitive that was hit.
void EmbreeScene::finish_hits(std::span<const Ray> rays, std::span<Hit> hits) const {
    std::size_t waiting = hits.size();  // index of a hit on a triangle that waits for a second one
    for (std::size_t i = 0; i < hits.size(); ++i) {
        Hit& hit = hits[i];
        if (!hit.valid()) continue;
        if (hit.instance != Hit::none) {
            hit.instance -= static_cast<std::uint32_t>(top_level_shapes_);
            hit.shape += instances_[hit.instance].first_shape;
        }
        if (hit.instance != Hit::none || shapes_[hit.shape].kind != ShapeKind::triangle_mesh) {
            finish_hit(rays[i], hit);
        } else if (waiting == hits.size()) {
            waiting = i;
        } else {
            finish_triangles({&rays[waiting], &rays[i]}, {&hits[waiting], &hit});
            waiting = hits.size();
        }
    }
    if (waiting < hits.size()) finish_hit(rays[waiting], hits[waiting]);
}

}  // namespace raylex::transport
