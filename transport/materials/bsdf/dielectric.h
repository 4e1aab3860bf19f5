// Glass: GGX microfacets that reflect and refract by Fresnel's share, ideal when smooth; and a thin pane of it.
//
// Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces"; pbrt-v4 book, 9.5 and 9.7. +z is the
// outside: a direction with z > 0 travels in the outer medium.
#pragma once

#include "transport/materials/bsdf/lobes.h"
#include "transport/materials/bsdf/microfacet.h"
#include "transport/materials/bsdf/scatter.h"
#include "transport/math/fresnel.h"

namespace raylex::transport {

/// A dielectric interface: the coat of a layered surface, or the one part of a GlassClosure.
struct DielectricClosure {
    Ggx facets;
    Real eta;  ///< inside over outside

    /// Index-matched interfaces are ideal whatever their roughness: refraction turns no direction, and the half vector
    /// of a transmitted pair, wo + eta wi, drowns in rounding (pbrt-v4 does so at eta = 1 exactly). Smith's masking
    /// leaves out light that meets the surface twice, so it would dim even light that nothing turns.
    static constexpr Real matched_within = Real(1.5e-4);

    [[nodiscard]] bool is_delta() const { return facets.smooth() || std::abs(eta - 1) < matched_within; }
    void regularize() { facets = facets.regularized(); }
    /// f |cos theta_i|; 0 for a delta.
    [[nodiscard]] Real value(Vec3 wo, Vec3 wi, TransportMode mode) const;
    [[nodiscard]] Real pdf(Vec3 wo, Vec3 wi, Sides sides) const;
    /// Without `density` the pdf of a rough sample is 1, for callers who compute pdf() of the rounded direction.
    [[nodiscard]] LocalSample draw(const Vec3& wo, Real u_lobe, const Vec2& u, TransportMode mode, Sides sides,
                                   bool density = true) const;

  private:
    [[nodiscard]] LocalSample draw_ideal(const Vec3& wo, Real u_lobe, TransportMode mode, Sides sides) const;
    [[nodiscard]] LocalSample draw_rough(const Vec3& wo, Real u_lobe, const Vec2& u, TransportMode mode, Sides sides,
                                         bool density) const;
};

/// A dielectric interface as a surface of its own: glass, or the border of a translucent body.
struct GlassClosure {
    DielectricClosure interface;
    bool subsurface = false;  ///< its lobes are `specular` and `subsurface`
    Sides sides = Sides::both;

    [[nodiscard]] LobeId lobe(bool transmitted, bool delta) const {
        if (!subsurface) return lobes::glass(transmitted, delta);
        if (transmitted) return lobes::subsurface;
        return delta ? lobes::specular_singular : lobes::specular_glossy;
    }
    [[nodiscard]] BsdfEvaluation evaluate(const Vec3& wo, const Vec3& wi) const {
        return one_lobe(lobe(wo.z * wi.z < 0, false), Rgb(interface.value(wo, wi, TransportMode::radiance)),
                        pdf(wo, wi));
    }
    [[nodiscard]] BsdfSample sample(const Vec3& wo, Real u_lobe, const Vec2& u) const {
        const LocalSample s = interface.draw(wo, u_lobe, u, TransportMode::radiance, sides, false);
        return one_lobe(lobe(s.transmitted, s.delta), s);
    }
    [[nodiscard]] Real pdf(const Vec3& wo, const Vec3& wi) const { return interface.pdf(wo, wi, sides); }
    [[nodiscard]] static Rgb albedo(const Vec3&) { return Rgb(1); }
    [[nodiscard]] bool has_density() const { return !interface.is_delta(); }
    [[nodiscard]] SideLobes side_lobes() const {
        const bool delta = interface.is_delta();
        return {lobe(false, delta), {lobe(true, delta), lobe(true, delta)}};
    }
    void regularize() { interface.regularize(); }
};

/// Two parallel ideal interfaces with all reflections between them: R = F + (1-F)^2 F / (1 - F^2), T = 1 - R; light
/// leaves in the direction it came.
struct ThinDielectricClosure {
    Real eta;
    Sides sides = Sides::both;

    [[nodiscard]] Real reflectance(Real cos_theta) const {
        const Real f = fresnel_dielectric(cos_theta, eta);
        return f < 1 ? 2 * f / (1 + f) : 1.0f;
    }
    [[nodiscard]] static BsdfEvaluation evaluate(const Vec3&, const Vec3&) { return {}; }
    [[nodiscard]] BsdfSample sample(const Vec3& wo, Real u_lobe, const Vec2&) const;
    [[nodiscard]] static Real pdf(const Vec3&, const Vec3&) { return 0; }
    [[nodiscard]] static Rgb albedo(const Vec3&) { return Rgb(1); }
    [[nodiscard]] static constexpr bool has_density() { return false; }
    [[nodiscard]] static SideLobes side_lobes() {
        return {lobes::glass_reflect_singular, {lobes::glass_transmit_singular, lobes::glass_transmit_singular}};
    }
};

}  // namespace raylex::transport
