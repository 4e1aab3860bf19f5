// Metal and glass that give back what single scattering between their facets drops: "raylex:compensate".
//
// Turquin 2019, "Practical multiple scattering compensation for microfacet models": the light that a second facet would
// have sent on goes where the first ones send theirs. Glass is divided by E(wo) (facet_albedo.h), so that R + T = 1; a
// metal is multiplied by 1 + F0 (1 - E(wo)) / E(wo) (equation 16 there), F0 its reflectance at normal incidence: 1 / E
// where nothing is absorbed, and less where every further facet absorbs its share. Directions are drawn as without
// compensation, so densities are the same and a sample's weight is at most 1 / E.
//
// The factor depends on the camera's direction alone, so f(wo, wi) is not reciprocal; energy is kept for light that
// arrives from everywhere. Light subpaths evaluate f(towards camera, towards light) as camera subpaths do
// (paths/scattering.h), so all integrators make one image.
//
// Neither is ever smooth or index-matched. Neither is regularized: materials of raylex have known answers.
#pragma once

#include "transport/materials/bsdf/conductor.h"
#include "transport/materials/bsdf/dielectric.h"
#include "transport/materials/bsdf/facet_albedo.h"

namespace raylex::transport {

struct CompensatedConductor {
    ConductorClosure metal;
    const FacetAlbedo* lossless;  ///< outlives the closure

    [[nodiscard]] Rgb gain(const Vec3& wo) const {
        const Real e = (*lossless)(metal.facets, wo);
        return Rgb(1) + metal.fresnel(1) * ((1 - e) / e);
    }
    [[nodiscard]] BsdfEvaluation evaluate(const Vec3& wo, const Vec3& wi) const {
        Real density;
        const Rgb single = metal.value_and_pdf(wo, wi, density);
        return one_lobe(lobes::conductor_glossy, density > 0 ? single * gain(wo) : single, density);
    }
    [[nodiscard]] BsdfSample sample(const Vec3& wo, Real, const Vec2& u) const {
        LocalSample s = metal.draw(wo, u, false);
        if (s.pdf > 0) s.weight *= gain(wo);
        return one_lobe(lobes::conductor_glossy, s);
    }
    [[nodiscard]] Real pdf(const Vec3& wo, const Vec3& wi) const { return metal.pdf(wo, wi); }
    [[nodiscard]] Rgb albedo(const Vec3& wo) const {
        const Real e = (*lossless)(metal.facets, wo);
        return metal.albedo(wo) * (Rgb(e) + metal.fresnel(1) * (1 - e));
    }
    [[nodiscard]] static constexpr bool has_density() { return true; }
};

struct CompensatedDielectric {
    DielectricClosure interface;
    const FacetAlbedo* lossless;  ///< outlives the closure

    [[nodiscard]] BsdfEvaluation evaluate(const Vec3& wo, const Vec3& wi) const {
        const Real single = interface.value(wo, wi, TransportMode::radiance);
        return one_lobe(lobes::glass(wo.z * wi.z < 0, false),
                        Rgb(single > 0 ? single / (*lossless)(interface.facets, wo) : 0.0f), pdf(wo, wi));
    }
    [[nodiscard]] BsdfSample sample(const Vec3& wo, Real u_lobe, const Vec2& u) const {
        LocalSample s = interface.draw(wo, u_lobe, u, TransportMode::radiance, Sides::both, false);
        if (s.pdf > 0) s.weight *= 1 / (*lossless)(interface.facets, wo);
        return one_lobe(lobes::glass(s.transmitted, false), s);
    }
    [[nodiscard]] Real pdf(const Vec3& wo, const Vec3& wi) const { return interface.pdf(wo, wi, Sides::both); }
    [[nodiscard]] static Rgb albedo(const Vec3&) { return Rgb(1); }
    [[nodiscard]] static constexpr bool has_density() { return true; }
};

}  // namespace raylex::transport
