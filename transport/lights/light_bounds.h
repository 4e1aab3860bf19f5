// The light that a group of lights sends to a place. Bounds serve to group lights and to exclude groups that send
// nothing (A. Conty Estevez and C. Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree Splitting", Proc.
// ACM CGIT 1(2), section 4, in the form of "Physically Based Rendering", 4th edition, section 12.6.3). Expected values
// serve to choose. Bounds overestimate nearby groups and groups with many orientations; choosing by expected values
// leaves a third to a twenty-fifth of the variance of choosing by bounds (experiments/docs/measured.md).
#pragma once

#include <array>

#include "transport/embree/embree_scene.h"
#include "transport/lights/light.h"

namespace raylex::transport {

/// The place at which light arrives.
struct LightReceiver {
    Vec3 position;
    Vec3 normal;  ///< unit, of either side; zero for points without a surface

    LightReceiver(const Vec3& p, const Vec3& n = {}) : position(p), normal(n) {}  // a position is enough
};

/// The directions into which lights emit: normals are within `theta_o` of `axis`, and light is within pi/2, or
/// `theta_e`, of the normals.
struct EmissionCone {
    Vec3 axis{0, 0, 1};  ///< unit
    Real cos_theta_o = -1;
    Real cos_theta_e = 0;  ///< slightly less than the exact value, to allow for rounding
    bool two_sided = false;

    /// Whether the cone excludes any direction.
    [[nodiscard]] bool is_narrow() const { return !two_sided && cos_theta_o > -1; }
    /// Returns false only if no light arrives. `way` leads to the receiver from the centre of a ball of squared radius
    /// `radius2` that contains all the lights.
    [[nodiscard]] bool reaches(const Vec3& way, Real radius2) const;
};

/// Bounds of lights that have a position.
struct LightBounds {
    Vec3 lower, upper;
    EmissionCone cone;
    Real power = 0;  ///< relative

    /// The cost of a node with these bounds in Conty Estevez and Kulla's heuristic, split along an axis of `whole`.
    [[nodiscard]] Real cost(const Vec3& whole, int axis) const;
    /// The squared radius of a ball around `center` that contains all lights.
    [[nodiscard]] Real radius_squared(const Vec3& center) const;
};

/// Moments of the positions and normals of lights. A light of normal n is modelled as sending strength max(0, n . w)
/// into direction w. A light that is equal in all directions is modelled as an even mixture of normals with n n^T of a
/// quarter.
struct LightMoments {
    Vec3 mean;                      ///< position; means are weighted by strength
    Real spread = 0;                ///< mean squared distance from `mean`
    std::array<Real, 6> squares{};  ///< mean of n n^T: xx, yy, zz, xy, xz, yz
    Vec3 facing;                    ///< mean of n; zero for lights that emit to both sides
    Real strength = 0;              ///< relative power over pi

    /// The expected contribution at the receiver, up to a factor that all lights share; always above 0.
    [[nodiscard]] double importance(const LightReceiver& receiver) const;
};

LightBounds bounds_of(const Light& light, const EmbreeScene& geometry, Real relative_power);
LightBounds join(const LightBounds& a, const LightBounds& b);
/// The moments of a single light with these bounds.
LightMoments moments_of(const Light& light, const LightBounds& bounds);
LightMoments join(const LightMoments& a, const LightMoments& b);

}  // namespace raylex::transport
