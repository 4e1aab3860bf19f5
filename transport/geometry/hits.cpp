// Where rays meet what the intersector says that they hit.
#include "transport/geometry/embree_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "transport/geometry/triangle_hit.h"

namespace raylex::transport {

bool ShapeGeometry::intersect(unsigned primitive, const DVec3& origin, const DVec3& direction, const Interval& range,
                              double& t, double& u, double& v) const {
    if (kind == ShapeKind::bilinear_mesh)
        return patch(primitive).intersect(origin, direction, range.lower, range.upper, t, u, v);
    return quadric.intersect(origin, direction, range.lower, range.upper, t, u, v);
}

/// How far from where it should be a point may come to lie by rounding, in the space of its shape's vertices: 4 units
/// in the last place, where the shape stands and, of an instance, in the world.
double EmbreeScene::rounding_at(const Hit& hit, const DVec3& point) const {
    double reach = std::max({std::abs(point.x), std::abs(point.y), std::abs(point.z)});
    if (hit.instance != Hit::none) {
        const Placement& placement = instances_[hit.instance].placement;
        const DVec3 world = placement.to_world.point(point);
        for (const auto& row : placement.to_object.m)
            reach += std::abs(row[0] * world.x) + std::abs(row[1] * world.y) + std::abs(row[2] * world.z);
    }
    return 0x1p-21 * reach;
}

/// What Embree calls by its own numbers is called by ours, and where the ray meets it is computed anew, from the ray
/// and the primitive alone. What is left of Embree in an image is which primitive was hit.
void EmbreeScene::finish_hit(const Ray& ray, Hit& hit) const {
    if (!hit.valid()) return;
    DVec3 origin(ray.origin), direction(ray.direction);
    if (hit.instance != Hit::none) {
        hit.instance -= static_cast<std::uint32_t>(top_level_shapes_);
        const ShapeInstance& placed = instances_[hit.instance];
        hit.shape += placed.first_shape;
        origin = placed.placement.to_object.point(origin);
        direction = placed.placement.to_object.vector(direction);
    }
    const ShapeGeometry& shape = shapes_[hit.shape];
    if (shape.kind == ShapeKind::triangle_mesh) {
        const std::uint32_t* index = shape.indices + 3 * static_cast<std::size_t>(hit.primitive);
        const DVec3 p0(shape.positions[index[0]]), p1(shape.positions[index[1]]), p2(shape.positions[index[2]]);
        TriangleHit found = meet_triangle(origin, direction, p0, p1, p2);
        keep_off_edges(found, p0, p1, p2, [&, at = found] {
            // What single precision does to the point, and to its weights.
            return rounding_at(hit, p0 + (p1 - p0) * at.u + (p2 - p0) * at.v) +
                   0x1p-23 * (length(p1 - p0) + length(p2 - p0));
        });
        hit.t = std::clamp(static_cast<Real>(found.t), Real(std::numeric_limits<float>::min()), ray.t_max);
        hit.u = static_cast<Real>(found.u);
        hit.v = static_cast<Real>(found.v);
    } else if (hit.instance != Hit::none || real_is_double) {
        // At the top level in float this is what Embree's callback did, of the same numbers.
        double t, u, v;
        if (shape.intersect(hit.primitive, origin, direction, {0, ray.t_max}, t, u, v)) {
            hit.t = static_cast<Real>(t);
            hit.u = static_cast<Real>(u);
            hit.v = static_cast<Real>(v);
        }
    }
    hit.cone = ray.cone.after(hit.t);
}

}  // namespace raylex::transport
