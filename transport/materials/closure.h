// The closure a material leaves at a hit: a fixed-size tagged value, evaluated by a switch.
#pragma once

#include "transport/materials/bsdf.h"

namespace raylex::transport {

/// Scattering at one point. All directions are world space, unit, pointing away from the surface. Radiance transport
/// (pbrt's TransportMode::Radiance): transmitted radiance is scaled by 1/eta^2.
class Bsdf {
  public:
    /// Sum over non-delta lobes of f |cos|, each lobe apart, and the density of sample().
    [[nodiscard]] BsdfEvaluation evaluate(const Vec3& wo, const Vec3& wi) const;
    /// u_lobe and u in [0, 1). A failed sample has pdf 0.
    [[nodiscard]] BsdfSample sample(const Vec3& wo, float u_lobe, const Vec2& u) const;
    [[nodiscard]] float pdf(const Vec3& wo, const Vec3& wi) const;
    /// Whether any lobe has a density: false means that light sampling is of no use here.
    [[nodiscard]] bool has_density() const;
    /// Rough estimate of the directional albedo, for the albedo AOV.
    [[nodiscard]] Rgb albedo(const Vec3& wo) const;

    // Storage is defined by the materials author.
};

}  // namespace raylex::transport
