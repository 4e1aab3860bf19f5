// Fresnel reflectance of plane interfaces, unpolarised (Born and Wolf, Principles of Optics, 1.5 and 14.2).
#pragma once

#include <algorithm>
#include <cmath>

#include "display/services/rgb.h"
#include "transport/math/sampling.h"

namespace raylex::transport {

/// Dielectric: `cos_theta` in [0, 1] on the incident side, `eta` = transmitted over incident index.
/// Total internal reflection gives exactly 1.
inline float fresnel_dielectric(float cos_theta, float eta) {
    const float cos_i = std::clamp(cos_theta, 0.0f, 1.0f);
    const float sin2_t = (1 - cos_i * cos_i) / (eta * eta);
    if (sin2_t >= 1) return 1;
    const float cos_t = safe_sqrt(1 - sin2_t);
    const float parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    const float perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    return (parallel * parallel + perpendicular * perpendicular) * 0.5f;
}

/// Conductor of complex index eta + i k, relative to the incident side, in real arithmetic.
inline float fresnel_conductor(float cos_theta, float eta, float k) {
    const float c = std::clamp(cos_theta, 0.0f, 1.0f);
    const float cos2 = c * c, sin2 = 1 - cos2;
    const float t0 = eta * eta - k * k - sin2;
    const float a2_plus_b2 = std::sqrt(t0 * t0 + 4 * eta * eta * k * k);
    const float a = safe_sqrt(0.5f * (a2_plus_b2 + t0));
    const float perpendicular = (a2_plus_b2 + cos2 - 2 * a * c) / (a2_plus_b2 + cos2 + 2 * a * c);
    const float even = cos2 * a2_plus_b2 + sin2 * sin2, odd = 2 * a * c * sin2;
    // At normal incidence both polarisations agree and even + odd = a2_plus_b2, which is 0 only for eta = k = 0.
    const float parallel = even + odd > 0 ? perpendicular * (even - odd) / (even + odd) : perpendicular;
    return std::clamp(0.5f * (parallel + perpendicular), 0.0f, 1.0f);
}

inline Rgb fresnel_conductor(float cos_theta, const Rgb& eta, const Rgb& k) {
    return {fresnel_conductor(cos_theta, eta.r, k.r), fresnel_conductor(cos_theta, eta.g, k.g),
            fresnel_conductor(cos_theta, eta.b, k.b)};
}

/// The k that with eta = 1 gives the normal-incidence reflectance `r` (as pbrt-v4's "reflectance" of a conductor; r is
/// kept below 1, where k is infinite).
inline float conductor_k_from_reflectance(float r) {
    const float clamped = std::clamp(r, 0.0f, 0.9999f);
    return 2 * std::sqrt(clamped) / std::sqrt(1 - clamped);
}
inline Rgb conductor_k_from_reflectance(const Rgb& r) {
    return {conductor_k_from_reflectance(r.r), conductor_k_from_reflectance(r.g), conductor_k_from_reflectance(r.b)};
}

}  // namespace raylex::transport
