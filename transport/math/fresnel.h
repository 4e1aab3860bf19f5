// Fresnel reflectance of plane interfaces, unpolarised (Born and Wolf, Principles of Optics, 1.5 and 14.2).
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>

#include "transport/math/real.h"
#include "transport/math/sampling.h"

namespace raylex::transport {

/// Squared cosine of the refracted direction by Snell's law; 0 or less for total internal reflection. `eta` =
/// transmitted over incident index. Differences are in double: near the critical angle, float would give cosines in
/// steps of 2e-4, between which reflectance is not monotone.
inline Real refracted_cosine_squared(Real cos_i, Real eta) {
    const double c = cos_i, n = eta;
    return static_cast<Real>(1 - (1 - c * c) / (n * n));
}

/// Fresnel reflectance of a dielectric. `cos_theta` in [0, 1] on the incident side, `eta` = transmitted over incident
/// index. Total internal reflection gives exactly 1.
inline Real fresnel_dielectric(Real cos_theta, Real eta) {
    const Real cos_i = std::clamp(cos_theta, Real(0), Real(1));
    const Real cos2_t = refracted_cosine_squared(cos_i, eta);
    if (cos2_t <= 0) return 1;
    const Real cos_t = std::sqrt(cos2_t);
    const Real parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    const Real perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    return (parallel * parallel + perpendicular * perpendicular) * 0.5f;
}

/// Fresnel reflectance of a conductor of complex index eta + i k, relative to the incident side, in real arithmetic.
template <std::floating_point Number>
Number fresnel_conductor(Number cos_theta, Number eta, Number k) {
    // All light is reflected to the last digit, and the fourth powers below would overflow float.
    if (eta > Number(1e9) || k > Number(1e9)) return 1;
    const Number c = std::clamp(cos_theta, Number(0), Number(1));
    const Number cos2 = c * c, sin2 = 1 - cos2;
    const Number t0 = eta * eta - k * k - sin2;
    const Number a2_plus_b2 = std::sqrt(t0 * t0 + 4 * eta * eta * k * k);
    // a^2 and b^2 are half the sum and half the difference of a2_plus_b2 and t0, and their product is eta^2 k^2. For
    // metals, whose t0 is negative, the sum would cancel.
    const Number wide = Number(0.5) * (a2_plus_b2 + std::abs(t0)), a2 = t0 < 0 ? eta * k * (eta * k) / wide : wide;
    const Number a = wide > 0 ? std::sqrt(a2) : Number(0);
    const Number perpendicular = (a2_plus_b2 + cos2 - 2 * a * c) / (a2_plus_b2 + cos2 + 2 * a * c);
    const Number even = cos2 * a2_plus_b2 + sin2 * sin2, odd = 2 * a * c * sin2;
    // At normal incidence both polarisations agree and even + odd = a2_plus_b2, which is 0 only for eta = k = 0.
    const Number parallel = even + odd > 0 ? perpendicular * (even - odd) / (even + odd) : perpendicular;
    return std::clamp(Number(0.5) * (parallel + perpendicular), Number(0), Number(1));
}

inline Rgb fresnel_conductor(Real cos_theta, const Rgb& eta, const Rgb& k) {
    const Real red = fresnel_conductor(cos_theta, eta.r, k.r);
    if (eta == Rgb(eta.r) && k == Rgb(k.r)) return Rgb(red);
    return {red, fresnel_conductor(cos_theta, eta.g, k.g), fresnel_conductor(cos_theta, eta.b, k.b)};
}

/// The k that gives the normal-incidence reflectance `r` with eta = 1 (pbrt-v4's "reflectance" of a conductor; r is
/// kept below 1, where k is infinite).
inline Real conductor_k_from_reflectance(Real r) {
    const Real clamped = std::clamp(r, Real(0), Real(0.9999));
    return 2 * std::sqrt(clamped) / std::sqrt(1 - clamped);
}
inline Rgb conductor_k_from_reflectance(const Rgb& r) {
    return {conductor_k_from_reflectance(r.r), conductor_k_from_reflectance(r.g), conductor_k_from_reflectance(r.b)};
}

}  // namespace raylex::transport
