// Warps from the unit square or interval to the domains that lights, cameras and closures sample, with their densities.
//
// Every warp takes numbers in [0, 1) and has no singular inputs: u = 0 and the largest float below 1 give finite
// points. Directions are in the local frame: +z is the normal, the axis or the pole.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "display/services/elementary.h"
#include "transport/math/vec.h"

namespace raylex::transport {

inline constexpr Real one_minus_epsilon = 1 - std::numeric_limits<Real>::epsilon() / 2;  ///< the largest number below 1

inline Real safe_sqrt(Real x) {
    return std::sqrt(std::max(Real(0), x));
}
constexpr Real square(Real x) {
    return x * x;
}
constexpr Real lerp(Real t, Real a, Real b) {
    return (1 - t) * a + t * b;
}

/// Sine and cosine on [-pi/4, pi/4] by their Taylor series, truncated where the error (2e-9) is below float's rounding:
/// without range reduction, and in float throughout. The double build uses elementary::sin_cos.
inline elementary::SinCos<Real> sin_cos_of_eighth(Real x) {
    if constexpr (real_is_double) return elementary::sin_cos(x);
    const Real x2 = x * x;
    return {x * (1 + x2 * (-1 / 6.0f + x2 * (1 / 120.0f + x2 * (-1 / 5040.0f + x2 / 362880.0f)))),
            1 + x2 * (-0.5f + x2 * (1 / 24.0f + x2 * (-1 / 720.0f + x2 * (1 / 40320.0f - x2 / 3628800.0f))))};
}

/// The point at `radius` from the origin, `turn` whole turns from the x axis.
inline Vec2 polar_point(Real radius, Real turn) {
    const auto [sine, cosine] = elementary::sin_cos(2 * pi * turn);
    return {radius * cosine, radius * sine};
}

/// `a` if `condition` holds, else `b`, without a branch: for unpredictable conditions. (Compilers make branches of a ?
/// : of floats if there is no instruction for it.)
inline Real select(bool condition, Real a, Real b) {
    using Bits = std::conditional_t<real_is_double, std::uint64_t, std::uint32_t>;
    const Bits mask = Bits{0} - static_cast<Bits>(condition);
    return std::bit_cast<Real>((std::bit_cast<Bits>(a) & mask) | (std::bit_cast<Bits>(b) & ~mask));
}

/// A point of the unit disk, by the concentric map: squares become rings, so strata stay compact (Shirley and Chiu
/// 1997, "A Low Distortion Map Between Disk and Square"). Density 1/pi per unit area.
inline Vec2 sample_disk(const Vec2& u) {
    const Real a = 2 * u.x - 1, b = 2 * u.y - 1, radius = std::max(std::abs(a), std::abs(b)),
               other = std::min(std::abs(a), std::abs(b));
    // The angle is measured from the nearer axis: at most pi/4.
    const auto angle = sin_cos_of_eighth(radius == 0 ? 0.0f : (pi / 4) * (other / radius));
    const Real along = radius * angle.cos, across = radius * angle.sin;
    const bool wide = std::abs(a) > std::abs(b);
    return {std::copysign(select(wide, along, across), a), std::copysign(select(wide, across, along), b)};
}

/// A point of the unit disk in polar coordinates: u.x is the squared radius, u.y the angle. Density 1/pi.
inline Vec2 sample_disk_polar(const Vec2& u) {
    return polar_point(std::sqrt(u.x), u.y);
}

/// A direction of the upper hemisphere, density cos(theta)/pi (Malley's method on the concentric disk).
inline Vec3 sample_cosine_hemisphere(const Vec2& u) {
    const Vec2 d = sample_disk(u);
    return {d.x, d.y, safe_sqrt(1 - d.x * d.x - d.y * d.y)};
}
constexpr Real cosine_hemisphere_pdf(Real cos_theta) {
    return cos_theta > 0 ? cos_theta * inv_pi : 0.0f;
}

inline Vec3 sample_uniform_hemisphere(const Vec2& u) {
    const Vec2 p = polar_point(safe_sqrt(1 - u.x * u.x), u.y);
    return {p.x, p.y, u.x};
}
constexpr Real uniform_hemisphere_pdf() {
    return inv_pi * 0.5f;
}

inline Vec3 sample_uniform_sphere(const Vec2& u) {
    const Real r = 2 * std::sqrt(u.x * (1 - u.x));  // sqrt(1 - z^2) without the cancellation at the poles
    const Vec2 p = polar_point(r, u.y);
    return {p.x, p.y, 1 - 2 * u.x};
}
constexpr Real uniform_sphere_pdf() {
    return inv_pi * 0.25f;
}

/// A direction in a cone about +z, given by 1 - cos(theta_max), which stays exact for tiny cones (see
/// one_minus_cos_of_sin2).
inline Vec3 sample_uniform_cone(const Vec2& u, Real one_minus_cos_max) {
    const Real h = u.x * one_minus_cos_max;  // 1 - cos(theta)
    const Vec2 p = polar_point(safe_sqrt(h * (2 - h)), u.y);
    return {p.x, p.y, 1 - h};
}
inline Real uniform_cone_pdf(Real one_minus_cos_max) {
    return 1 / (2 * pi * one_minus_cos_max);
}
/// 1 - cos(theta) from sin^2(theta), theta in [0, pi/2]: the plain difference loses all digits at 1e-4 rad.
inline Real one_minus_cos_of_sin2(Real sin2) {
    return sin2 / (1 + safe_sqrt(1 - sin2));
}

/// Barycentrics (b0, b1), b2 = 1 - b0 - b1, uniform over a triangle by folding, which keeps strata compact
/// (Heitz 2019, "A Low-Distortion Map Between Triangle and Square").
inline Vec2 sample_uniform_triangle(const Vec2& u) {
    const Real half = std::min(u.x, u.y) * 0.5f;  // the smaller one minus its half is exactly its half
    return {u.x - half, u.y - half};
}

/// Density proportional to lerp(x, a, b) on [0, 1]; a, b >= 0, not both 0.
inline Real linear_pdf(Real x, Real a, Real b) {
    return x < 0 || x > 1 ? 0.0f : 2 * lerp(x, a, b) / (a + b);
}
inline Real sample_linear(Real u, Real a, Real b) {
    if (u == 0 && a == 0) return 0;
    const Real x = u * (a + b) / (a + std::sqrt(lerp(u, a * a, b * b)));
    return std::min(x, one_minus_epsilon);
}

/// Density proportional to the bilinear interpolation of corner weights w00 (x=0,y=0), w10 (x=1,y=0), w01, w11.
inline Real bilinear_pdf(const Vec2& p, Real w00, Real w10, Real w01, Real w11) {
    if (p.x < 0 || p.x > 1 || p.y < 0 || p.y > 1) return 0;
    const Real sum = w00 + w10 + w01 + w11;
    if (!(sum > 0)) return 1;
    return 4 * lerp(p.y, lerp(p.x, w00, w10), lerp(p.x, w01, w11)) / sum;
}
inline Vec2 sample_bilinear(const Vec2& u, Real w00, Real w10, Real w01, Real w11) {
    if (!(w00 + w10 + w01 + w11 > 0)) return u;
    const Real y = sample_linear(u.y, w00 + w10, w01 + w11);
    return {sample_linear(u.x, lerp(y, w00, w01), lerp(y, w10, w11)), y};
}

/// Weight of a sample drawn with density `a` if another strategy has density `b`: the power heuristic with exponent 2
/// (Veach 1997, section 9.2.4). It is computed as a ratio, so that densities near the limits of float neither overflow
/// nor give NaN. a = inf (a delta) gives 1, or one half if b = inf too; a = 0 gives 0.
inline Real power_heuristic(Real a, Real b) {
    if (!(a > 0)) return 0;
    if (std::isinf(a)) return std::isinf(b) ? Real(0.5) : Real(1);
    const Real ratio = b / a;
    return 1 / (1 + ratio * ratio);
}

/// Re-uses a number that was compared with `threshold` (the probability of the first branch): uniform in [0, 1) again.
inline Real remap_below(Real u, Real threshold) {
    return std::min(u / threshold, one_minus_epsilon);
}
inline Real remap_above(Real u, Real threshold) {
    return std::min((u - threshold) / (1 - threshold), one_minus_epsilon);
}

/// The upper 24 bits as a float in [0, 1): never 1.
constexpr Real unit_float(std::uint64_t bits) {
    return static_cast<Real>(bits >> 40) * 0x1p-24f;
}

}  // namespace raylex::transport
