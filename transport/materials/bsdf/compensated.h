// Metal and glass that give back what single scattering between their facets drops: "raylex:compensate".
//
// Turquin 2019, "Practical multiple scattering compensation for microfacet models": the light that a second facet would
// have sent on goes where the first ones send theirs. Glass is divided by E(wo) (facet_albedo.h), so that R + T = 1; a
// metal is multiplied by 1 + F0 (1 - E(wo)) / E(wo) (equation 16 there), F0 its reflectance at normal incidence: 1 / E
// where nothing is absorbed, and less where every further facet takes its share. Directions are drawn as without, so
// densities are the same and a sample's weight is at most 1 / E.
//
// The factor knows the camera's direction only, so f(wo, wi) is not reciprocal; energy is kept for light that arrives
// from everywhere. Light subpaths ask for f(towards camera, towards light) as camera subpaths do
// (paths/scattering.h), so all integrators make one image.
#pragma once

#include "transport/materials/bsdf/conductor.h"
#include "transport/materials/bsdf/dielectric.h"
#include "transport/materials/bsdf/facet_albedo.h"

namespace raylex::transport {

/// Never smooth; `lossless` outlives every use. What draw() gives has a pdf of 1: see ConductorClosure.
struct CompensatedConductor {
    ConductorClosure metal;
    const FacetAlbedo* lossless;

    [[nodiscard]] Rgb gain(const Vec3& wo) const {
        const Real e = (*lossless)(metal.facets, wo);
        return Rgb(1) + metal.fresnel(1) * ((1 - e) / e);
    }
    [[nodiscard]] Rgb value_and_pdf(const Vec3& wo, const Vec3& wi, Real& pdf) const {
        const Rgb single = metal.value_and_pdf(wo, wi, pdf);
        return pdf > 0 ? single * gain(wo) : single;
    }
    [[nodiscard]] LocalSample draw(const Vec3& wo, const Vec2& u) const {
        LocalSample s = metal.draw(wo, u, false);
        if (s.pdf > 0) s.weight *= gain(wo);
        return s;
    }
    [[nodiscard]] Rgb albedo(const Vec3& wo) const {
        const Real e = (*lossless)(metal.facets, wo);
        return metal.albedo(std::abs(wo.z)) * (Rgb(e) + metal.fresnel(1) * (1 - e));
    }
};

/// Never smooth nor index-matched; draw() as above.
struct CompensatedDielectric {
    DielectricClosure glass;
    const FacetAlbedo* lossless;

    [[nodiscard]] Real value(const Vec3& wo, const Vec3& wi) const {
        const Real single = glass.value(wo, wi, TransportMode::radiance);
        return single > 0 ? single / (*lossless)(glass.facets, wo) : 0.0f;
    }
    [[nodiscard]] LocalSample draw(const Vec3& wo, Real u_lobe, const Vec2& u) const {
        LocalSample s = glass.draw(wo, u_lobe, u, TransportMode::radiance, Sides::both, false);
        if (s.pdf > 0) s.weight *= 1 / (*lossless)(glass.facets, wo);
        return s;
    }
};

}  // namespace raylex::transport
