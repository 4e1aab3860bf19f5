// Ideal diffuse reflection and transmission: leaves, paper, lampshades (pbrt-v4's diffusetransmission). Light leaves by
// cosine on wo's side with f = reflectance / pi and on the other with f = transmittance / pi; no interface, no index.
#pragma once

#include "transport/materials/bsdf/lambert.h"

namespace raylex::transport {

struct DiffuseTransmissionClosure {
    Rgb reflectance, transmittance;  ///< not both black

    /// Chance of reflecting, by the largest colours as in pbrt-v4: then no colour's weight is above the sum of both.
    [[nodiscard]] Real reflection_probability(Sides sides) const {
        if (sides != Sides::both) return sides == Sides::reflection ? 1.0f : 0.0f;
        return reflectance.max() / (reflectance.max() + transmittance.max());
    }
    [[nodiscard]] Rgb value(const Vec3& wo, const Vec3& wi) const {
        return (wo.z * wi.z > 0 ? reflectance : transmittance) * (wo.z == 0 ? 0 : std::abs(wi.z) * inv_pi);
    }
    [[nodiscard]] Real pdf(const Vec3& wo, const Vec3& wi, Sides sides) const {
        if (wo.z == 0 || wi.z == 0) return 0;
        const Real p = reflection_probability(sides);
        return (wo.z * wi.z > 0 ? p : 1 - p) * std::abs(wi.z) * inv_pi;
    }
    [[nodiscard]] LocalSample sample(const Vec3& wo, Real u_lobe, const Vec2& u, Sides sides) const {
        const Real p = reflection_probability(sides);
        LocalSample s = LambertClosure{}.sample(wo, 0, u);
        s.transmitted = !(u_lobe < p);
        if (s.transmitted) s.wi.z = -s.wi.z;
        s.pdf *= s.transmitted ? 1 - p : p;
        s.weight = s.transmitted ? transmittance / (1 - p) : reflectance / p;
        return s;
    }
};

}  // namespace raylex::transport
