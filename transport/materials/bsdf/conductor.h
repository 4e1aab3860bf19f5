// Metal: GGX microfacets with complex Fresnel reflectance, or an ideal mirror of it when smooth.
//
// Single scattering between facets, as in pbrt-v4 (book, 4th edition, 9.3 and 9.6): rough metals lose some energy.
#pragma once

#include "transport/materials/bsdf/lobes.h"
#include "transport/materials/bsdf/microfacet.h"
#include "transport/materials/bsdf/scatter.h"
#include "transport/math/fresnel.h"

namespace raylex::transport {

/// Mirrors both directions so that wo is above; false where no light is reflected or the surface is seen edge-on.
[[nodiscard]] bool to_upper_side(Vec3& wo, Vec3& wi);

struct ConductorClosure {
    Ggx facets;
    Rgb eta, k;                 ///< complex index relative to the outside
    bool constant_reflectance;  ///< `eta` is the reflectance itself, at every angle

    [[nodiscard]] Rgb fresnel(Real cos_theta) const {
        return constant_reflectance ? eta : fresnel_conductor(cos_theta, eta, k);
    }
    [[nodiscard]] bool is_delta() const { return facets.smooth(); }
    [[nodiscard]] bool has_density() const { return !is_delta(); }
    [[nodiscard]] static constexpr LobeId lobe(bool delta) { return lobes::conductor(delta); }
    [[nodiscard]] Rgb albedo(const Vec3& wo) const { return fresnel(std::abs(wo.z)); }
    void regularize() { facets = facets.regularized(); }

    [[nodiscard]] BsdfEvaluation evaluate(const Vec3& wo, const Vec3& wi) const {
        Real density;
        const Rgb f = value_and_pdf(wo, wi, density);
        return one_lobe(lobe(false), f, density);
    }
    [[nodiscard]] BsdfSample sample(const Vec3& wo, Real, const Vec2& u) const {
        return one_lobe(lobe(is_delta()), draw(wo, u, false));
    }
    [[nodiscard]] Real pdf(Vec3 wo, Vec3 wi) const;

    /// f |cos theta_i|; 0 for a delta.
    [[nodiscard]] Rgb value(Vec3 wo, Vec3 wi) const;
    /// Value and density at once, for half the work.
    [[nodiscard]] Rgb value_and_pdf(Vec3 wo, Vec3 wi, Real& pdf) const;
    /// Without `density` the pdf of a rough sample is 1, for callers who compute pdf() of the rounded direction.
    [[nodiscard]] LocalSample draw(Vec3 wo, const Vec2& u, bool density = true) const;
};

}  // namespace raylex::transport
