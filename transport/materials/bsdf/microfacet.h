// The GGX (Trowbridge-Reitz) distribution of microfacet normals, anisotropic, with Smith masking.
//
// All directions are in the shading frame with z >= 0: closures mirror both directions first. Formulas:
// Walter et al. 2007, "Microfacet Models for Refraction"; Heitz 2014, "Understanding the Masking-Shadowing Function";
// visible normals by spherical caps: Dupuy and Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps".
#pragma once

#include <algorithm>
#include <cmath>

#include "transport/math/sampling.h"
#include "transport/math/vec.h"

namespace raylex::transport {

/// Directions nearer to the horizon than this give no sample, no density and no value.
inline constexpr Real min_cosine = Real(1e-7);

struct Ggx {
    /// Both alphas below this: an ideal, delta interface (pbrt-v4's EffectivelySmooth).
    static constexpr Real smooth_below = Real(1e-3);

    Real alpha_x, alpha_y;

    /// A rough axis beside a smooth one is kept at 1e-4, where the density still has digits to spare in float.
    static constexpr Ggx from_alpha(Real x, Real y) {
        if (!(std::max(x, y) >= smooth_below)) return {0, 0};
        return {std::clamp(x, Real(1e-4), Real(1e3)), std::clamp(y, Real(1e-4), Real(1e3))};
    }
    /// pbrt-v4's remapping of the user's roughness.
    static Real alpha_from_roughness(Real roughness) { return safe_sqrt(roughness); }

    [[nodiscard]] constexpr bool smooth() const { return alpha_x == 0; }
    /// Blurred like pbrt-v4's "regularize": alphas below 0.3 become twice as large, from 0.1 to 0.3.
    [[nodiscard]] constexpr Ggx regularized() const {
        const auto wider = [](Real a) { return a < Real(0.3) ? std::clamp(2 * a, Real(0.1), Real(0.3)) : a; };
        return {wider(alpha_x), wider(alpha_y)};
    }

    /// Density of normals per steradian: integral of D cos = 1. In a form without cancellation around the pole.
    [[nodiscard]] Real d(const Vec3& m) const {
        const Real s = square(m.x / alpha_x) + square(m.y / alpha_y) + square(m.z);
        return 1 / (pi * alpha_x * alpha_y * s * s);
    }
    /// Smith's Lambda: masked over visible area; w.z >= min_cosine.
    [[nodiscard]] Real lambda(const Vec3& w) const {
        const Real a2_tan2 = (square(alpha_x * w.x) + square(alpha_y * w.y)) / square(w.z);
        return (std::sqrt(1 + a2_tan2) - 1) * 0.5f;
    }
    [[nodiscard]] Real g1(const Vec3& w) const { return 1 / (1 + lambda(w)); }
    /// Height-correlated masking and shadowing.
    [[nodiscard]] Real g2(const Vec3& wo, const Vec3& wi) const { return 1 / (1 + lambda(wo) + lambda(wi)); }

    /// A normal visible from `w`, with density g1(w) d(m) max(0, w.m) / w.z.
    [[nodiscard]] Vec3 sample_visible_normal(const Vec3& w, const Vec2& u) const {
        const Vec3 stretched = normalize({alpha_x * w.x, alpha_y * w.y, w.z});
        const Real z = (1 - u.x) * (1 + stretched.z) - stretched.z;  // uniform on the cap z in (-stretched.z, 1]
        const Vec2 p = polar_point(safe_sqrt(1 - z * z), u.y);
        const Vec3 h = Vec3{p.x, p.y, z} + stretched;
        return normalize({alpha_x * h.x, alpha_y * h.y, std::max(Real(1e-6) * length(h), h.z)});
    }
};

constexpr Vec3 reflect(const Vec3& w, const Vec3& m) {
    return m * (2 * dot(w, m)) - w;
}

}  // namespace raylex::transport
