// Points on area lights, uniform over a triangle or quadric, or in the parameters of a patch. Light samples and light
// paths start from them. Each function fills in target, target_normal, target_offset and uv, and returns the density
// per world area.
#pragma once

#include <cmath>

#include "transport/embree/embree_scene.h"
#include "transport/lights/light.h"
#include "transport/math/sampling.h"

namespace raylex::transport {

inline Real sample_triangle_point(const Light& light, const Vec2& u, LightSample& s) {
    const Vec2 b = sample_uniform_triangle(u);
    s.uv = {b.y, 1 - b.x - b.y};
    s.target = light.position + light.edge1 * b.y + light.edge2 * (1 - b.x - b.y);
    s.target_normal = light.direction;
    s.target_offset = light.offset;
    return 1 / light.area;
}

/// Draws a point of a patch; returns 0 if the patch has no area.
inline Real sample_patch_point(const Light& light, const ShapeGeometry& shape, const Vec2& u, LightSample& s) {
    const BilinearPatch patch = shape.patch(light.primitive);
    const DVec3 n = cross(patch.dpdu(u.y), patch.dpdv(u.x));
    const double area = length(n);
    if (!(area > 0)) return 0;
    s.uv = u;
    s.target = patch.point(u.x, u.y).to_real();
    s.target_normal = (n * ((shape.flip_normal && shape.normals.empty() ? -1 : 1) / area)).to_real();
    if (!shape.normals.empty())
        s.target_normal = face_forward(
            s.target_normal, shape.normals[shape.patch_indices[4 * static_cast<std::size_t>(light.primitive)]]);
    s.target_offset = offset_of_rounded(s.target_normal, s.target, patch.extent());
    return static_cast<Real>(1 / area);
}

inline Real sample_quadric_point(const Quadric& quadric, const Vec2& u, LightSample& s) {
    double a, b;
    quadric.sample_area(u.x, u.y, a, b);
    const Quadric::Point point = quadric.world_point(a, b);
    s.uv = {static_cast<Real>(a), static_cast<Real>(b)};
    s.target = point.position.to_real();
    s.target_normal = point.normal.to_real();
    s.target_offset = offset_of_rounded(s.target_normal, s.target, quadric.extent());
    return static_cast<Real>(1 / (quadric.object_area() * point.area_scale));
}

/// The random numbers in [0, 1]^2 for which sample_*_point() returns `at` (u and v of a Hit).
inline Vec2 numbers_of_point(const Light& light, const ShapeGeometry& shape, const Vec2& at) {
    if (light.kind == LightKind::patch) return at;
    if (light.kind == LightKind::triangle) {
        const Real b0 = 1 - at.x - at.y, b1 = at.x;
        return b0 < b1 ? Vec2{2 * b0, b1 + b0} : Vec2{b0 + b1, 2 * b1};
    }
    double a, b;
    shape.quadric.area_numbers(static_cast<double>(at.x), static_cast<double>(at.y), a, b);
    return {static_cast<Real>(a), static_cast<Real>(b)};
}

/// The density per world area with which sample_*_point() draws a point.
inline double density_of_point(const Light& light, const ShapeGeometry& shape, const Vec2& at) {
    if (light.kind == LightKind::triangle) return 1 / light.area;
    if (light.kind == LightKind::patch) {
        const BilinearPatch patch = shape.patch(light.primitive);
        return 1 / length(cross(patch.dpdu(at.y), patch.dpdv(at.x)));
    }
    return 1 / (shape.quadric.object_area() * shape.quadric.world_point(at.x, at.y).area_scale);
}

}  // namespace raylex::transport
