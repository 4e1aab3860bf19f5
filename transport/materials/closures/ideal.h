// Closures whose every lobe has constant reflectance: what analytic scenes and tests of attribution are made of.
#pragma once

#include "transport/materials/bsdf/conductor.h"
#include "transport/materials/bsdf/lambert.h"

namespace raylex::transport {

/// Lambert reflection, ideal mirror and straight-through transmission on one surface, each of constant reflectance.
/// sample() picks a lobe in proportion to the means of the three colours.
struct IdealClosure {
    Rgb diffuse, mirror, sheet;

    [[nodiscard]] BsdfEvaluation evaluate(const Vec3& wo, const Vec3& wi) const {
        return one_lobe(lobes::diffuse, LambertClosure{diffuse}.value(wo, wi), pdf(wo, wi));
    }
    [[nodiscard]] BsdfSample sample(const Vec3& wo, Real u_lobe, const Vec2& u) const;
    [[nodiscard]] Real pdf(const Vec3& wo, const Vec3& wi) const;
    [[nodiscard]] Rgb albedo(const Vec3&) const { return diffuse + mirror + sheet; }
    [[nodiscard]] bool has_density() const { return !diffuse.is_black(); }

  private:
    [[nodiscard]] Real total() const { return diffuse.average() + mirror.average() + sheet.average(); }
};

/// The sum of a Lambert and a GGX lobe that overlap everywhere: a direction is drawn from one of them, both are
/// evaluated, and the density is that of the mixture (Law 5's test surface).
struct AdditiveClosure {
    LambertClosure diffuse;
    ConductorClosure specular;  ///< never smooth

    [[nodiscard]] BsdfEvaluation evaluate(const Vec3& wo, const Vec3& wi) const;
    [[nodiscard]] BsdfSample sample(const Vec3& wo, Real u_lobe, const Vec2& u) const;
    [[nodiscard]] Real pdf(const Vec3& wo, const Vec3& wi) const { return evaluate(wo, wi).pdf; }
    [[nodiscard]] Rgb albedo(const Vec3& wo) const { return diffuse.reflectance + specular.albedo(wo); }
    [[nodiscard]] static constexpr bool has_density() { return true; }

  private:
    [[nodiscard]] Real diffuse_probability() const;
};

}  // namespace raylex::transport
