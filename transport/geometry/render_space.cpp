#include "transport/geometry/render_space.h"

#include <algorithm>
#include <cmath>

#include "transport/geometry/ray.h"

namespace raylex::transport {
namespace {

bool finite(const DVec3& p) {
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

/// The smallest power of two that is at least `extent`, divided by 2^16.
double grid_of(double extent) {
    int exponent = 0;
    std::frexp(extent, &exponent);
    return std::ldexp(1.0, exponent - 16);
}

/// The point of [lower, upper] nearest to `p`, on the grid if the interval contains a grid point.
double nearest_in(double lower, double upper, double p, double grid) {
    const double inside = std::clamp(p, lower, upper);
    const double rounded = grid > 0 ? std::nearbyint(inside / grid) * grid : inside;
    return std::isfinite(rounded) ? rounded : inside;
}

bool usable(const Transform& transform) {
    return transform.invertible() && finite(DVec3(transform.point_in_double({0, 0, 0})));
}

bool in_range(const DBounds& b) {
    const double limit = largest_coordinate;
    return std::max({-b.lower.x, -b.lower.y, -b.lower.z, b.upper.x, b.upper.y, b.upper.z}) <= limit;
}

DBounds bounds_of(const SceneObject& object) {
    DBounds bounds;
    for (const SceneShape& shape : object.shapes)
        if (shape.object_to_world.invertible()) bounds.add(object_bounds(shape), shape.object_to_world);
    return bounds;
}

}  // namespace

void DBounds::add(const DVec3& p) {
    if (!finite(p)) return;
    lower = {std::min(lower.x, p.x), std::min(lower.y, p.y), std::min(lower.z, p.z)};
    upper = {std::max(upper.x, p.x), std::max(upper.y, p.y), std::max(upper.z, p.z)};
}

void DBounds::add(const DBounds& box, const Transform& placement) {
    if (box.empty()) return;
    for (int corner = 0; corner < 8; ++corner)
        add(DVec3(
            placement.point_in_double({corner & 1 ? box.upper.x : box.lower.x, corner & 2 ? box.upper.y : box.lower.y,
                                       corner & 4 ? box.upper.z : box.lower.z})));
}

DVec3 DBounds::nearest(const DVec3& p) const {
    if (empty()) return p;
    const DVec3 size = upper - lower;
    const double extent = std::max({size.x, size.y, size.z});
    const double grid = extent > 0 && std::isfinite(extent) ? grid_of(extent) : 0;
    return {nearest_in(lower.x, upper.x, p.x, grid), nearest_in(lower.y, upper.y, p.y, grid),
            nearest_in(lower.z, upper.z, p.z, grid)};
}

DBounds object_bounds(const SceneShape& shape) {
    DBounds bounds;
    if (shape.kind == ShapeKind::triangle_mesh || shape.kind == ShapeKind::bilinear_mesh ||
        shape.kind == ShapeKind::curves) {
        for (const StoredVec3& p : shape.positions) bounds.add({p.x, p.y, p.z});
        return bounds;
    }
    const double r = shape.radius;
    const bool disk = shape.kind == ShapeKind::disk;
    bounds.add({-r, -r, disk ? shape.height : shape.z_min});
    bounds.add({r, r, disk ? shape.height : shape.z_max});
    return bounds;
}

RenderSpace RenderSpace::of(const SceneDescription& scene) {
    RenderSpace space;
    if (!usable(scene.camera_to_world)) return space;
    const DVec3 camera(scene.camera_to_world.point_in_double({0, 0, 0}));
    if (!in_range({camera, camera})) return space;
    DBounds bounds;
    // coordinates out of range become an error later
    const auto take = [&](const DBounds& box, const Transform& to_world) {
        if (!to_world.invertible()) return;
        DBounds placed;
        placed.add(box, to_world);
        if (in_range(placed)) bounds.add(placed, Transform());
    };
    for (const SceneShape& shape : scene.shapes) take(object_bounds(shape), shape.object_to_world);
    std::vector<DBounds> objects;
    for (const SceneObject& object : scene.objects) objects.push_back(bounds_of(object));
    for (const SceneInstance& instance : scene.instances) {
        const auto object = static_cast<std::size_t>(instance.object);
        if (instance.object >= 0 && object < objects.size()) take(objects[object], instance.to_world);
    }
    space.origin = bounds.nearest(camera);
    return space;
}

Transform RenderSpace::placed(const Transform& to_world, const DVec3& pivot) const {
    const bool moves = origin != DVec3() || pivot != DVec3();
    if (!moves || !to_world.invertible()) return to_world;
    const Matrix4& m = to_world.matrix();
    const Matrix4 inverse = to_world.inverse().matrix();
    const auto affine = [](const Matrix4& a) { return a[3][0] == 0 && a[3][1] == 0 && a[3][2] == 0 && a[3][3] == 1; };
    if (!affine(m) || !affine(inverse))
        return Transform::translate(-origin.x, -origin.y, -origin.z) * to_world *
               Transform::translate(pivot.x, pivot.y, pivot.z);
    // Not the product of the inverses, whose large translations would cancel.
    Matrix4 moved = m, back = inverse;
    const double by[3] = {origin.x, origin.y, origin.z};
    for (std::size_t r = 0; r < 3; ++r)
        moved[r][3] += m[r][0] * pivot.x + m[r][1] * pivot.y + m[r][2] * pivot.z - by[r];
    for (std::size_t r = 0; r < 3; ++r)
        back[r][3] = -(back[r][0] * moved[0][3] + back[r][1] * moved[1][3] + back[r][2] * moved[2][3]);
    return {moved, back};
}

Matrix4 RenderSpace::from_world(const Matrix4& from_here) const {
    Matrix4 result = from_here;
    for (std::size_t r = 0; r < 4; ++r)
        result[r][3] -= from_here[r][0] * origin.x + from_here[r][1] * origin.y + from_here[r][2] * origin.z;
    return result;
}

DVec3 pivot_of(const SceneObject& object) {
    const DBounds bounds = bounds_of(object);
    return bounds.empty() ? DVec3() : bounds.nearest({0, 0, 0});
}

}  // namespace raylex::transport
