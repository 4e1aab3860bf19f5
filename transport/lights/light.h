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
    sphere,  ///< area lights; `sphere`: a full sphere whose transform keeps it a sphere
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
    bool hidden = false;     ///< area lights of alpha 0: no ray hits them, they only light (pbrt-v4's invisible lights)
    std::int32_t group = 0;  ///< index into LightTable::groups()
    /// Radiance (area, environments), radiant intensity (lights at a point), or irradiance on a surface that faces it
    /// (distant). With an image: a factor on it.
    Rgb emission;
    Vec3 position;         ///< of a light at a point; triangle: vertex 0
    Vec3 direction;        ///< spot, projection: the axis; distant: towards it; triangle: unit normal, emitting side
    Vec3 edge1, edge2;     ///< triangle
    OffsetBound offset{};  ///< triangle: of points drawn on it
    Real area = 0;         ///< triangle, patch: world; quadric: object space; sphere: world
    /// Spot: 1 - cos of the angles at which the falloff begins and ends, in the light's own space. Projection: of the
    /// cone around its image. (The cosines of narrow cones are 1 in float.)
    Real versine_full = 0, versine_zero = 1;
    std::uint32_t shape = 0, primitive = 0;  ///< area lights
    std::int32_t image = -1;                 ///< index in the list of LightImages for the kind; -1: none
    double power = 0;                        ///< power estimate in relative units, the weight of the light's selection

    [[nodiscard]] bool is_delta() const { return hidden || (kind >= LightKind::point && kind <= LightKind::distant); }
    [[nodiscard]] bool is_environment() const { return kind >= LightKind::uniform_environment; }
    [[nodiscard]] bool is_area() const { return kind < LightKind::point; }
    /// Whether the light has no extent and is at `position`.
    [[nodiscard]] bool is_at_point() const { return kind >= LightKind::point && kind < LightKind::distant; }
};

/// 1 - cos of the angle between unit directions, without cancellation.
inline Real versine_between(const Vec3& a, const Vec3& b) {
    return 0.5f * length_squared(a - b);
}

/// The share of a spot light's intensity in a unit direction: a smoothstep of the cosine between the two angles.
inline Real spot_falloff(const Vec3& axis, Real versine_full, Real versine_zero, const Vec3& direction) {
    const Real x = (versine_zero - versine_between(direction, axis)) / (versine_zero - versine_full);
    if (!(x > 0)) return 0;
    const Real t = std::min(x, Real(1));
    return t * t * (3 - 2 * t);
}

/// A direction towards a light, and the radiance that arrives from there if it is unoccluded.
struct LightSample {
    Rgb radiance;        ///< delta lights: intensity / d^2 or irradiance, to be divided by `pdf` as for other lights
    Vec3 wi;             ///< unit, from the lit point
    Real pdf = 0;        ///< per steradian, times the probability of the choice; delta lights: that probability
    Vec3 target;         ///< the point on the light; unused when `infinite`
    Vec3 target_normal;  ///< zero for points
    OffsetBound target_offset{};  ///< of `target`
    Vec2 uv;                      ///< area lights: the place on the primitive, as in Hit
    std::uint32_t light = 0;
    bool delta = false, infinite = false;
};

/// The start of a light path.
struct EmissionSample {
    LightSample
        from;  ///< target, target_normal, target_offset, uv and light of the start; for infinite lights the light only
    Vec3 origin;     ///< off the surface
    Vec3 direction;  ///< unit
    Rgb power;       ///< radiance times cosine over the density of all choices: its mean is the light's emitted power
};

/// The densities with which a light path begins somewhere, in the measures of bidirectional MIS weights.
struct EmissionDensity {
    /// Density of the point, per area, times the probability of the light's choice. For a light at infinity: the
    /// density of the direction, per steradian. For a light at a point or a distant light: the probability of the
    /// choice alone.
    Real position = 0;
    Real direction = 0;  ///< per steradian; for a light at infinity: density of the ray across the beam, per area
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
