// A dielectric coat over an opaque base, with an optional medium between them, solved by random walks.
//
// The model is pbrt-v4's LayeredBxDF (book, 4th edition, 14.3; Guo et al. 2018, "Position-Free Monte Carlo Simulation
// for Arbitrary Layered BSDFs") for the two-sided materials that pbrt-v4 has: light enters and leaves through the coat,
// so the surface only reflects. Values are unbiased estimates: they come from walks whose random numbers are a hash of
// the surface point's key and the directions, so that equal arguments give equal values (Law 3), and value and
// sample are independent of one another.
//
// pdf() differs from pbrt-v4's, which estimates it by further walks: here it is a closed form near the true density,
// and deterministic, so that weights of multiple importance sampling that rest on it are unbiased whatever its quality.
//
// A bias kept for agreement. Under a rough coat, pbrt-v4 weighs a walk that leaves in a sampled direction against the
// density of refracting *out* along it, where the competing strategy refracts *in* from the light: the weights do not
// sum to 1 and values come out too large (measured, entered light of a Lambert base: +1 % at alpha 0.05, +3 % at 0.15,
// +9 % at 0.4), while sample() is unbiased. Materials of scene files have `as_pbrt` set, which keeps the
// bias, so that images agree with pbrt-v4's. Without it both strategies agree, whatever the light sampling.
//
// A gap shared with pbrt-v4: over a smooth metal under a smooth coat with a scattering medium between them, evaluate()
// has no connection for light whose last turn after the medium is the metal's mirror image; only sample() finds it.
//
// Attribution. Light that never entered is the coat's; all that entered is the base's. evaluate() keeps the two apart
// exactly. sample() walks: the lobe is the one the walk took, which for a smooth coat is exact too, since a delta and
// a density never meet. Under a rough coat the density of the walked direction, summed over all walks that could have
// given it, has no closed form, so neither beauty nor any channel can weigh by it: the sample's weight is the walk's
// own and belongs to the walk's lobe alone. Law 5 then holds with equality, beauty's estimator being the picked one
// itself.
#pragma once

#include <cstdint>

#include "transport/materials/bsdf/dielectric.h"

namespace raylex::transport {

/// The coat and the slab below it.
struct CoatLayer {
    DielectricClosure interface;
    Real thickness;              ///< optical: the medium's extinction is 1 per unit
    Real g;                      ///< Henyey-Greenstein asymmetry of the medium
    Rgb albedo;                  ///< of the medium; black: it only absorbs
    std::uint16_t max_depth;     ///< layers visited per walk
    std::uint16_t sample_count;  ///< walks averaged per evaluation
    /// Rough coats only: evaluate as pbrt-v4 does, see the head of this file. False: unbiased.
    bool as_pbrt;
};

/// `Base` is LambertClosure or ConductorClosure. wo and wi may be on either side; the model is the same from both.
template <class Base>
struct LayeredClosure {
    CoatLayer coat;
    Base base;
    std::uint32_t key = 0;      ///< of the random walks: SurfacePoint::random_key
    Sides sides = Sides::both;  ///< to which the coat sends light where it meets it first

    [[nodiscard]] BsdfEvaluation evaluate(const Vec3& wo, const Vec3& wi) const;
    /// The pdf is that of the walk, clamped to [1e-30, 1e30].
    [[nodiscard]] BsdfSample sample(Vec3 wo, Real u_lobe, const Vec2& u) const;
    /// An approximate density for multiple importance sampling, positive over the whole hemisphere, whose integral is
    /// at most 1 (but for a rough coat's own small error).
    [[nodiscard]] Real pdf(Vec3 wo, Vec3 wi) const;
    [[nodiscard]] Rgb albedo(const Vec3& wo) const;
    [[nodiscard]] bool has_density() const {
        return !(coat.interface.is_delta() &&
                 (sides == Sides::reflection || (!base.has_density() && coat.albedo.is_black())));
    }
    [[nodiscard]] SideLobes side_lobes() const {
        // A medium between coat and base gives a mirror a density too.
        return {lobes::coat(coat.interface.is_delta()), {Base::lobe(true), Base::lobe(false)}};
    }
    void regularize() {
        coat.interface.regularize();
        base.regularize();
    }

    /// The coat's part of f |cos theta_i|: exact.
    [[nodiscard]] Real coat_value(Vec3 wo, Vec3 wi) const;
    /// The part that entered: an unbiased estimate.
    [[nodiscard]] Rgb base_value(Vec3 wo, Vec3 wi) const;
};

}  // namespace raylex::transport
