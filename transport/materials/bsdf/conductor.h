// Metal: GGX microfacets with complex Fresnel reflectance, or an ideal mirror of it when smooth.
//
// Single scattering between facets, as in pbrt-v4 (book, 4th edition, 9.3 and 9.6): rough metals lose some energy.
#pragma once

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
    /// f |cos theta_i|; 0 for a delta.
    [[nodiscard]] Rgb value(Vec3 wo, Vec3 wi) const;
    [[nodiscard]] Real pdf(Vec3 wo, Vec3 wi) const;
    /// Both at once, for half the work.
    [[nodiscard]] Rgb value_and_pdf(Vec3 wo, Vec3 wi, Real& pdf) const;
    [[nodiscard]] LocalSample sample(Vec3 wo, Real, const Vec2& u) const { return draw(wo, u, true); }
    /// Without `density` the pdf of a rough sample is left at 1, for callers who ask pdf() of the direction as they
    /// round it.
    [[nodiscard]] LocalSample draw(Vec3 wo, const Vec2& u, bool density) const;
    [[nodiscard]] Rgb albedo(Real cos_theta) const { return fresnel(cos_theta); }
};

}  // namespace raylex::transport
