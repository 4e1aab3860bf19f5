// Closures whose every lobe has constant reflectance: what analytic scenes and tests of attribution are made of.
#pragma once

#include "transport/materials/bsdf/conductor.h"
#include "transport/materials/bsdf/lambert.h"
#include "transport/materials/bsdf/scatter.h"

namespace raylex::transport {

/// Lambert reflection, ideal mirror and straight-through transmission on one surface, each of constant reflectance.
/// sample() picks a lobe in proportion to the means of the three colours.
struct IdealClosure {
    Rgb diffuse, mirror, sheet;

    [[nodiscard]] Real total() const { return diffuse.average() + mirror.average() + sheet.average(); }
    [[nodiscard]] Real diffuse_probability() const { return diffuse.average() / total(); }
    /// `lobe` tells which was taken: 0 diffuse, 1 mirror, 2 sheet. Failure when all three are black.
    [[nodiscard]] LocalSample sample(const Vec3& wo, Real u_lobe, const Vec2& u, int& lobe) const;
};

/// The sum of a Lambert and a GGX lobe that overlap everywhere: a direction is drawn from one of them, both are
/// evaluated, and the density is that of the mixture (Law 5's test surface).
struct AdditiveClosure {
    LambertClosure diffuse;
    ConductorClosure specular;  ///< never smooth

    /// Chance of drawing from the Lambert lobe.
    [[nodiscard]] Real diffuse_probability() const;
    /// Draws a direction only: values and density follow from evaluating both lobes. False on failure.
    [[nodiscard]] bool sample_direction(const Vec3& wo, Real u_lobe, const Vec2& u, Vec3& wi) const;
};

}  // namespace raylex::transport
