// Glass: GGX microfacets that reflect and refract by Fresnel's share, ideal when smooth; and a thin pane of it.
//
// Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces"; pbrt-v4 book, 9.5 and 9.7. +z is the
// outside: a direction with z > 0 travels in the outer medium.
#pragma once

#include "transport/materials/bsdf/microfacet.h"
#include "transport/materials/bsdf/scatter.h"
#include "transport/math/fresnel.h"

namespace raylex::transport {

struct DielectricClosure {
    Ggx facets;
    Real eta;  ///< inside over outside

    /// Index-matched interfaces are ideal whatever their roughness: refraction turns no direction, and the half vector
    /// of a transmitted pair, wo + eta wi, drowns in rounding (pbrt-v4 does so at eta = 1 exactly). Smith's masking,
    /// which knows no light that meets the surface twice, would dim even light that nothing turns.
    static constexpr Real matched_within = Real(1.5e-4);

    [[nodiscard]] bool is_delta() const { return facets.smooth() || std::abs(eta - 1) < matched_within; }
    /// f |cos theta_i|; 0 for a delta.
    [[nodiscard]] Real value(Vec3 wo, Vec3 wi, TransportMode mode) const;
    [[nodiscard]] Real pdf(Vec3 wo, Vec3 wi, Sides sides) const;
    [[nodiscard]] LocalSample sample(const Vec3& wo, Real u_lobe, const Vec2& u, TransportMode mode,
                                     Sides sides) const {
        return draw(wo, u_lobe, u, mode, sides, true);
    }
    /// Without `density` the pdf of a rough sample is left at 1, for callers who ask pdf() of the direction as they
    /// round it.
    [[nodiscard]] LocalSample draw(const Vec3& wo, Real u_lobe, const Vec2& u, TransportMode mode, Sides sides,
                                   bool density) const;

  private:
    [[nodiscard]] LocalSample sample_ideal(const Vec3& wo, Real u_lobe, TransportMode mode, Sides sides) const;
    [[nodiscard]] LocalSample sample_rough(const Vec3& wo, Real u_lobe, const Vec2& u, TransportMode mode, Sides sides,
                                           bool density) const;
};

/// Two parallel ideal interfaces with all reflections between them: R = F + (1-F)^2 F / (1 - F^2), T = 1 - R; light
/// leaves in the direction it came.
struct ThinDielectricClosure {
    Real eta;

    [[nodiscard]] Real reflectance(Real cos_theta) const {
        const Real f = fresnel_dielectric(cos_theta, eta);
        return f < 1 ? 2 * f / (1 + f) : 1.0f;
    }
    [[nodiscard]] LocalSample sample(const Vec3& wo, Real u_lobe, Sides sides) const;
};

}  // namespace raylex::transport
