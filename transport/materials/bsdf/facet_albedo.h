// How much light rough facets return when each ray meets one of them only: tables for compensation.
//
// Single scattering between facets, which is what GGX closures compute, drops light that would meet a second facet. The
// share that is left, E(wo), is the directional albedo of facets that absorb nothing: R of metal whose reflectance is
// 1, R + T of glass. It has no closed form. Tables are integrated here, once, when a scene needs them: over visible
// normals, by 2048 or 4096 points of the R2 lattice (Roberts 2018, "The Unreasonable Effectiveness of Quasirandom
// Sequences"), made periodic by a smoothstep. Against 2^22 points they are right to 5e-4, interpolation included to
// 1e-3.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "transport/materials/bsdf/microfacet.h"

namespace raylex::transport {

/// E(wo) of facets, wo in the shading frame on either side. Immutable.
class FacetAlbedo {
  public:
    /// A table for the facets `only`, or without it for isotropic facets of any roughness. `eta` is 0 for metal, else
    /// the index of glass, inside over outside.
    FacetAlbedo(const std::optional<Ggx>& only, Real eta);

    /// In (0, 1]. `facets` must be `only`, or isotropic.
    [[nodiscard]] Real operator()(const Ggx& facets, const Vec3& wo) const;

    /// The integral that the table holds, over `points` facets. wo.z > 0; `eta` is relative to wo's side.
    static double integrate(const Ggx& facets, const Vec3& wo, Real eta, int points);

    /// The table for these arguments, integrated at most once in a process. Safe to call from several threads.
    static std::shared_ptr<const FacetAlbedo> shared(const std::optional<Ggx>& only, Real eta);

  private:
    [[nodiscard]] Real along_cosine(std::size_t row, Real x) const;
    [[nodiscard]] std::size_t rows() const { return static_cast<std::size_t>(azimuths_ * alphas_); }

    int cosines_, azimuths_ = 1, alphas_ = 1;
    bool glass_;
    std::vector<float> table_;  ///< [side][alpha][azimuth][cosine]
};

}  // namespace raylex::transport
