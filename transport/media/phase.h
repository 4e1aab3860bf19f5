// The Henyey-Greenstein phase function, stable for every asymmetry.
//
// All formulas use h = 1 - cos(theta), where theta is the angle to the axis of the lobe: the forward direction for g >
// 0, the backward direction for g < 0. Near g = 1 the cosine itself loses all its digits, and near g = 0 the common
// inversion divides by g. These forms keep a relative error of some ulps from g = 0 to g = 1 - 2^-24.
#pragma once

#include <algorithm>
#include <cmath>

#include "transport/math/sampling.h"

namespace raylex::transport {

struct PhaseSample {
    Vec3 wi;
    Real pdf = 0;  ///< per steradian; the phase function itself has the same value
};

namespace phase_detail {

/// The phase function (1 - g^2) / (4 pi (1 + g^2 - 2 g cos)^(3/2)), for g >= 0.
inline Real value(Real g, Real h) {
    const Real d = (1 - g) * (1 - g) + 2 * g * h;
    return (0.25f * inv_pi) * ((1 - g) * (1 + g)) / (d * std::sqrt(d));
}

}  // namespace phase_detail

/// Value and density, per steradian, of scattering light that travels along `forward` into `wi`; both unit. -1 < g < 1.
inline Real phase_pdf(Real g, const Vec3& forward, const Vec3& wi) {
    const Vec3 axis = g < 0 ? -forward : forward;
    return phase_detail::value(std::abs(g), std::min(Real(0.5) * length_squared(wi - axis), Real(2)));
}

/// Draws wi in proportion to the phase function, so the weight is 1. u in [0, 1)^2.
inline PhaseSample sample_phase(Real g, const Vec3& forward, const Vec2& u) {
    const Real a = std::abs(g);
    const Real denominator = (1 - a) + 2 * a * (1 - u.x);
    const Real h =
        std::clamp(2 * (1 - a) * (1 - a) * u.x * (1 + a - a * u.x) / (denominator * denominator), Real(0), Real(2));
    const Vec2 p = polar_point(std::sqrt(h * (2 - h)), u.y);
    const Frame frame = Frame::from_normal(g < 0 ? -forward : forward);
    const Vec3 wi = normalize(frame.to_world({p.x, p.y, 1 - h}));
    return {wi, phase_pdf(g, forward, wi)};  // of the rounded direction
}

}  // namespace raylex::transport
