// Light scattered by a hair, seen as a rough dielectric cylinder filled with pigment, of which one line along its
// length is shaded at a time: Chiang, Bitterli, Tappan and Burley 2016, "A Practical and Controllable Hair and Fur
// Model for Production Path Tracing"; longitudinal lobes of d'Eon et al. 2011, "An Energy-Conserving Hair Reflectance
// Model".
//
// x is along the fibre, z the shading normal. Directions are known by theta, the angle to the plane across the fibre,
// and phi around it: w = (sin theta, cos theta cos phi, cos theta sin phi). With A the light left after p passages
// (Fresnel and absorption), M and N densities over theta and phi,
//
//     f |cos| = sum over p of A_p(wo) M_p(theta_o, theta_i) N_p(phi_i - phi_o)
//
// p = 0: R, reflected at the surface; 1: TT, through the fibre; 2: TRT, reflected once inside; 3: TRRT, all others,
// evenly around the fibre. The sum of A is 1 without absorption: a white furnace stays white. A depends on wo alone, so
// the value is not symmetric; all methods evaluate it with wo towards the camera.
#pragma once

#include <array>

#include "transport/materials/bsdf/scatter.h"

namespace raylex::transport {

struct HairParameters {
    Real h = 0;               ///< where across the fibre the ray meets it, -1 to 1
    Real eta = Real(1.55);    ///< index of the fibre
    Rgb sigma_a;              ///< absorption, per fibre radius
    Real beta_m = Real(0.3);  ///< longitudinal roughness, 0 to 1
    Real beta_n = Real(0.3);  ///< azimuthal roughness, 0 to 1
    Real alpha = 2;           ///< angle of the scales on the fibre, degrees
};

class HairClosure {
  public:
    static constexpr int lobe_count = 4;

    explicit HairClosure(const HairParameters& parameters);

    [[nodiscard]] BsdfEvaluation evaluate(const Vec3& wo, const Vec3& wi) const;
    [[nodiscard]] Real pdf(const Vec3& wo, const Vec3& wi) const;
    /// Draws a lobe by its mean attenuation, then theta and phi by the lobe's densities.
    [[nodiscard]] BsdfSample sample(const Vec3& wo, Real u_lobe, const Vec2& u) const;
    /// Exact: the share of the light from wo that leaves the fibre.
    [[nodiscard]] Rgb albedo(const Vec3& wo) const;
    [[nodiscard]] static constexpr bool has_density() { return true; }

  private:
    struct Fibre;
    struct Tilted {
        Real sine, cosine;
    };
    [[nodiscard]] Tilted tilted(int lobe, Real sine, Real cosine) const;
    [[nodiscard]] Real longitudinal_variance(int lobe) const;
    [[nodiscard]] std::array<Real, lobe_count> densities(const Fibre& fibre, const Vec3& wi) const;

    Real h_, eta_;
    Rgb sigma_a_;
    Real variance_;               // of R; TT has a quarter of it, the others four times as much
    Real scale_;                  // of the logistic around the fibre
    std::array<Tilted, 3> tilt_;  // of alpha, 2 alpha and 4 alpha
};

/// Absorption, per fibre radius, of melanin concentrations (Chiang et al., section 6.1; coefficients of d'Eon et al.
/// in linear sRGB).
Rgb hair_absorption_of_melanin(Real eumelanin, Real pheomelanin);
/// Absorption that gives dense hair this colour (Chiang et al., equation 9).
Rgb hair_absorption_of_reflectance(const Rgb& reflectance, Real beta_n);

}  // namespace raylex::transport
