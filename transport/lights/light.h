// A light as plain data, evaluated by a switch on its kind.
#pragma once

#include <algorithm>
#include <cstdint>

#include "transport/geometry/ray.h"
#include "transport/math/real.h"
#include "transport/math/vec.h"

namespace raylex::transport {

enum class LightKind : std::uint8_t {
    triangle,
    patch,
    quadric,
    sphere,  ///< area lights; `sphere`: a full one that its transform keeps a sphere
    point,
    spot,
    goniometric,
    projection,
    distant,  ///< delta lights: no ray ever hits them
    uniform_environment,
    image_environment,
    portal_environment  ///< infinite
};

struct Light {
    LightKind kind = LightKind::point;
    bool two_sided = false;
    bool hidden = false;  ///< area lights of alpha 0: no ray finds them, they only light (pbrt-v4's invisible lights)
    std::int32_t group = 0;  ///< index into LightTable::groups()
    /// Radiance (area, environments), radiant intensity (lights at a point), or irradiance on a surface facing it
    /// (distant); where there is an image a factor on it.
    Rgb emission;
    Vec3 position;         ///< of a light at a point; triangle: vertex 0
    Vec3 direction;        ///< spot, projection: the axis; distant: towards it; triangle: unit normal, emitting side
    Vec3 edge1, edge2;     ///< triangle
    OffsetBound offset{};  ///< triangle: of points that are drawn on it
    Real area = 0;         ///< triangle, patch: world; quadric: object space; sphere: world
    /// Spot: 1 - cos of the angles where the falloff begins and ends, in the light's own space; projection: of the cone
    /// around its image. The cosines of narrow cones are 1 in float.
    Real versine_full = 0, versine_zero = 1;
    std::uint32_t shape = 0, primitive = 0;  ///< area lights
    std::int32_t image = -1;                 ///< index in what LightImages has for the kind; -1: none
    double power = 0;                        ///< watts-like estimate, the weight of its selection

    [[nodiscard]] bool is_delta() const { return hidden || (kind >= LightKind::point && kind <= LightKind::distant); }
    [[nodiscard]] bool is_environment() const { return kind >= LightKind::uniform_environment; }
    [[nodiscard]] bool is_area() const { return kind < LightKind::point; }
    /// Without an extent, at `position`.
    [[nodiscard]] bool is_at_point() const { return kind >= LightKind::point && kind < LightKind::distant; }
};

/// 1 - cos of the angle between unit directions, without cancellation.
inline Real versine_between(const Vec3& a, const Vec3& b) {
    return 0.5f * length_squared(a - b);
}

/// What a spot light sends into a unit direction, as a share of its intensity: a smoothstep of the cosine between the
/// two angles.
inline Real spot_falloff(const Vec3& axis, Real versine_full, Real versine_zero, const Vec3& direction) {
    const Real x = (versine_zero - versine_between(direction, axis)) / (versine_zero - versine_full);
    if (!(x > 0)) return 0;
    const Real t = std::min(x, Real(1));
    return t * t * (3 - 2 * t);
}

/// A direction towards a light, and what would arrive from there if nothing is in between.
struct LightSample {
    Rgb radiance;        ///< delta lights: intensity / d^2 or irradiance, to be divided by `pdf` like the others
    Vec3 wi;             ///< unit, from the lit point
    Real pdf = 0;        ///< per steradian times the chance of the choice; delta lights: that chance
    Vec3 target;         ///< the point on the light; unused when `infinite`
    Vec3 target_normal;  ///< zero for points
    OffsetBound target_offset{};  ///< of `target`
    Vec2 uv;                      ///< area lights: where on the primitive, as Hit has it
    std::uint32_t light = 0;
    bool delta = false, infinite = false;
};

/// Where a light path begins.
struct EmissionSample {
    LightSample
        from;  ///< target, target_normal, target_offset, uv and light of where it leaves; of infinite lights the light
    Vec3 origin;     ///< off the surface
    Vec3 direction;  ///< unit
    Rgb power;       ///< radiance times cosine over the density of all choices: what the light emits, in the mean
};

/// How likely a light path is to begin somewhere, in the measures that bidirectional weights want.
struct EmissionDensity {
    /// Of the point, per area, times the chance of the light's choice; of a light at infinity the density of the
    /// direction, per steradian; of a point or a distant light the choice alone.
    Real position = 0;
    Real direction = 0;  ///< per steradian; of a light at infinity, of the ray across the beam, per area
};

/// The ray that tests whether `sample` is visible from `position`.
inline Ray shadow_ray(const Vec3& position, const Vec3& geometric_normal, Real offset, const LightSample& sample) {
    Ray ray;
    ray.origin = offset_ray_origin(position, geometric_normal, offset, sample.wi);
    if (sample.infinite) {
        ray.direction = sample.wi;
        return ray;
    }
    return segment_to(ray.origin, sample.target, sample.target_normal, sample.target_offset);
}

}  // namespace raylex::transport
