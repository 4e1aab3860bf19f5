// Rays, hits, and the origins of new rays on surfaces.
//
// There is no absolute epsilon. A hit comes with `offset`, a bound on the distance between the computed point and the
// plane that the intersector tests, derived from the rounding of the operations that made both (see surface.cpp). A new
// ray starts that far along the geometric normal, on the side that it leaves to, so the surface it left is always
// behind it. Scaling or moving the scene scales the bound with the coordinates. The idea is pbrt-v4's OffsetRayOrigin;
// the bound is our own, because Embree's Pluecker test rounds elsewhere.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "transport/math/vec.h"

namespace raylex::transport {

inline constexpr Real infinity = std::numeric_limits<Real>::infinity();
inline constexpr Real unit_roundoff = 0x1p-24f;  ///< of float, even where Real is double: Embree rounds to float
/// Bound on the relative error of n roundings (Higham 2002, lemma 3.1).
constexpr Real gamma_bound(int n) {
    return (Real(n) * unit_roundoff) / (1 - Real(n) * unit_roundoff);
}

/// The largest distance from the origin at which shapes stand and rays begin: squares of lengths must be floats, and
/// Embree accepts no number above 1.8e18.
inline constexpr Real largest_coordinate = Real(1e18);

/// The distance off a surface at which rays begin, and at which rays from elsewhere end.
struct OffsetBound {
    Real here = 0;
    Real per_distance = 0;  ///< added per unit of length of a ray that comes from afar
};

/// OffsetBound::per_distance of a triangle. `spread` is |a_i b_j| + |a_j b_i| of its edges, summed over the three
/// components of their cross product N, over |N|: at least 1. Embree moves the vertices to the ray's far origin. With u
/// = 2^-24 and d the distance, each coordinate is off by u d, and the plane by 1.8 u d at the point. Edges are off by 2
/// u d, so the tilt of the normal adds 7 u d spread. The test itself adds gamma(4) d, and the direction's rounding
/// moves the end by u d. The sum is below 16 u d spread. Slivers seen from afar would need more than is possible: they
/// get 2^-13, about the part that pbrt-v4 cuts off every shadow ray (its ShadowEpsilon is 1e-4).
constexpr Real offset_per_distance(Real spread) {
    return std::clamp(Real(0x1p-20) * spread, Real(0x1p-20), Real(0x1p-13));
}

/// The offset bound of a point with unit normal `n`, on a shape whose hits are solved in double and whose coordinates
/// reach to `extent`: one rounding to float each for the point and for the origin made from it, and the error of the
/// solution.
inline OffsetBound offset_of_rounded(const Vec3& n, const Vec3& p, double extent) {
    return {gamma_bound(3) * dot(absolute(n), absolute(p)) + static_cast<Real>(1e-13 * extent), offset_per_distance(1)};
}

/// The width of the beam that a ray stands for (Amanatides 1984, "Ray Tracing with Cones"), which filters texture
/// look-ups where rays hit surfaces. Scattering leaves it unchanged if no image is filtered; else paths/footprints.h
/// applies curvature and roughness.
struct RayCone {
    Real width = 0;   ///< at the ray's origin, or at the hit
    Real spread = 0;  ///< angle, radians: the growth of the width per unit of distance

    [[nodiscard]] RayCone after(Real distance) const { return {width + spread * distance, spread}; }
};

struct Ray {
    Vec3 origin;
    Real t_max = infinity;
    Vec3 direction;  ///< unit for scattering rays; origin to light for shadow rays, with t_max below 1
    Real time = 0;   ///< relative to the shutter, 0 to 1
    RayCone cone{};  ///< of rays that carry radiance or importance; unused for shadow rays
};

struct Hit {
    static constexpr std::uint32_t none = 0xffffffffu;
    Real t = infinity;
    Real u = 0, v = 0;              ///< triangle: barycentrics of vertices 1 and 2; curve: along, and across from -1
                                    ///< to 1; others: the shape's own (u, v)
    std::uint32_t shape = none;     ///< index into EmbreeScene::shapes()
    std::uint32_t primitive = 0;    ///< triangle or patch of a mesh
    std::uint32_t instance = none;  ///< index into EmbreeScene::instances()
    Real time = 0;                  ///< of the ray
    RayCone cone{};                 ///< of the ray, at the hit

    [[nodiscard]] bool valid() const { return shape != none; }
};

inline float next_up(float v) {
    if (std::isinf(v) && v > 0) return v;
    if (v == 0) return std::numeric_limits<float>::min();  // denormals are flushed to zero while rendering
    const auto bits = std::bit_cast<std::uint32_t>(v);
    return std::bit_cast<float>(v > 0 ? bits + 1 : bits - 1);
}
inline float next_down(float v) {
    return -next_up(-v);
}

/// The origin of a ray that leaves `p` in `direction`: `offset` along the unit normal `n`, on the direction's side.
/// Each coordinate that moves is moved further by 2^-23 of itself, at least an ulp, so that rounding cannot undo the
/// step. The sign of the move is practically random from ray to ray, so the code has no branches.
[[gnu::always_inline]] inline Vec3 offset_ray_origin(const Vec3& p, const Vec3& n, Real offset, const Vec3& direction) {
    const Vec3 shift = n * std::copysign(offset, dot(n, direction));
    const auto step = [](Real coordinate, Real by) {
        const Real moved = coordinate + by;
        // A coordinate that does not move at all is not moved further: any move exceeds 2^-126.
        const Real further = std::min(std::abs(moved) * 0x1p-23f, std::abs(by) * 0x1p126f);
        return moved + std::copysign(further, by);
    };
    return {step(p.x, shift.x), step(p.y, shift.y), step(p.z, shift.z)};
}

/// The origin of a pass-through ray, which continues through the surface that it hit at the distance `t`, at `p`.
/// Rounding can put that point well before the hit or even behind the ray's origin (the nearest point of a grazed
/// triangle, a point projected onto a flattened quadric). The ray would go backwards then, perhaps for ever. In that
/// case it continues from the hit along itself, by the bound and two ulps of the largest coordinate, so that each pass
/// makes progress.
inline Vec3 straight_ray_origin(const Ray& ray, Real t, const Vec3& p, const Vec3& n, Real offset) {
    const Vec3 beyond = offset_ray_origin(p, n, offset, ray.direction);
    const Real progress = dot(beyond - ray.origin, ray.direction), due = t * length_squared(ray.direction);
    if (progress > 0 && progress >= Real(0.5) * due) [[likely]]
        return beyond;
    const Vec3 hit = ray.origin + ray.direction * t;
    const Real step = offset + 0x1p-22f * std::max({std::abs(hit.x), std::abs(hit.y), std::abs(hit.z)});
    return hit + normalize(ray.direction) * step;
}

/// Segments end this share of their length short of their end. Otherwise rounding alone would hit the surface on which
/// a light without area or the camera stands, or whose plane contains it.
inline constexpr Real end_of_segment = 1 - Real(0x1p-20);

/// The segment from `from`, where a ray may begin, to the point `to` of a surface with unit normal `n` (0: none),
/// shortened by its offset and by end_of_segment. The common 1e-4 of the length would miss a wall right before the
/// point.
inline Ray segment_to(const Vec3& from, const Vec3& to, const Vec3& n, const OffsetBound& offset) {
    const Vec3 way = to - from;
    const Real reach = std::abs(way.x) + std::abs(way.y) + std::abs(way.z);
    Ray ray;
    ray.origin = from;
    ray.direction = offset_ray_origin(to, n, offset.here + offset.per_distance * reach, -way) - from;
    ray.t_max = end_of_segment;
    return ray;
}

}  // namespace raylex::transport
