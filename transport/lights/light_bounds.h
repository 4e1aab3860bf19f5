// What a group of lights sends where: what is bounded, to group them and to leave out what sends nothing (A. Conty
// Estevez and C. Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree Splitting", Proc. ACM CGIT 1(2),
// section 4, in the form of "Physically Based Rendering", 4th edition, section 12.6.3), and what is to be expected, to
// choose by. Bounds make near groups and those that face anywhere look stronger than they are; choosing by what is
// expected leaves a third to a twenty-fifth of the variance of choosing by bounds (experiments/docs/measured.md).
#pragma once

#include <array>

#include "transport/embree/embree_scene.h"
#include "transport/lights/light.h"

namespace raylex::transport {

/// Where light is to arrive.
struct LightReceiver {
    Vec3 position;
    Vec3 normal;  ///< unit, either side; zero where there is no surface

    LightReceiver(const Vec3& p, const Vec3& n = {}) : position(p), normal(n) {}  // a position alone will do
};

/// Around which directions lights emit: normals within `theta_o` of `axis`, and light within pi/2, or `theta_e`, of
/// those.
struct EmissionCone {
    Vec3 axis{0, 0, 1};  ///< unit
    Real cos_theta_o = -1;
    Real cos_theta_e = 0;  ///< a little less than it is, for rounding
    bool two_sided = false;

    /// Whether it leaves any direction out.
    [[nodiscard]] bool is_narrow() const { return !two_sided && cos_theta_o > -1; }
    /// False only where nothing arrives: `way` leads there from the middle of a ball of squared radius `radius2` with
    /// all the lights in it.
    [[nodiscard]] bool reaches(const Vec3& way, Real radius2) const;
};

/// Of lights that stand somewhere.
struct LightBounds {
    Vec3 lower, upper;
    EmissionCone cone;
    Real power = 0;  ///< relative

    /// What Conty Estevez and Kulla's heuristic takes a node of these bounds to cost, split along an axis of `whole`.
    [[nodiscard]] Real cost(const Vec3& whole, int axis) const;
    /// Squared radius of a ball around `center` with all of them in it.
    [[nodiscard]] Real radius_squared(const Vec3& center) const;
};

/// Moments of where lights are and where they face. A light of normal n is taken to send strength max(0, n . w) into
/// direction w; one that sends alike everywhere is as good as an even mixture of normals with n n^T of a quarter.
struct LightMoments {
    Vec3 mean;                      ///< position; means are weighed by strength
    Real spread = 0;                ///< squared distance from there, in the mean
    std::array<Real, 6> squares{};  ///< mean of n n^T: xx, yy, zz, xy, xz, yz
    Vec3 facing;                    ///< mean of n; zero for what sends to both sides
    Real strength = 0;              ///< power over pi, relative

    /// What is to be expected at the receiver, up to a factor that all lights share; always above 0.
    [[nodiscard]] double importance(const LightReceiver& receiver) const;
};

LightBounds bounds_of(const Light& light, const EmbreeScene& geometry, Real relative_power);
LightBounds join(const LightBounds& a, const LightBounds& b);
/// Of a single light with these bounds.
LightMoments moments_of(const Light& light, const LightBounds& bounds);
LightMoments join(const LightMoments& a, const LightMoments& b);

}  // namespace raylex::transport
