// Bounds on what a group of lights sends where: A. Conty Estevez and C. Kulla 2018, "Importance Sampling of Many Lights
// with Adaptive Tree Splitting", Proc. ACM CGIT 1(2), section 4, in the form of "Physically Based Rendering", 4th
// edition, section 12.6.3.
#pragma once

#include "transport/geometry/embree_scene.h"
#include "transport/lights/light.h"

namespace raylex::transport {

/// Where light is to arrive.
struct LightReceiver {
    Vec3 position;
    Vec3 normal;  ///< unit, either side; zero where there is no surface

    LightReceiver(const Vec3& p, const Vec3& n = {}) : position(p), normal(n) {}  // a position alone will do
};

/// Of lights that stand somewhere: where, around which directions they emit (normals within `theta_o` of `axis`, and
/// light within pi/2, or `theta_e`, of those), and how much.
struct LightBounds {
    Vec3 lower, upper;
    Vec3 axis;  ///< unit
    Real cos_theta_o = -1;
    Real cos_theta_e = 0;  ///< a little less than it is, for rounding
    Real power = 0;        ///< relative
    bool two_sided = false;

    /// Bounds what arrives, up to a factor that all lights share; 0 only where nothing does.
    [[nodiscard]] Real importance(const LightReceiver& receiver) const;
    /// What Conty Estevez and Kulla's heuristic takes a node of these bounds to cost, split along an axis of `whole`.
    [[nodiscard]] Real cost(const Vec3& whole, int axis) const;
};

LightBounds bounds_of(const Light& light, const EmbreeScene& geometry, Real relative_power);
LightBounds join(const LightBounds& a, const LightBounds& b);

}  // namespace raylex::transport
