// Ideal diffuse reflection and transmission: leaves, paper, lampshades (pbrt-v4's diffusetransmission). Light leaves by
// cosine on wo's side with f = reflectance / pi and on the other with f = transmittance / pi; no interface, no index.
#pragma once

#include "transport/materials/bsdf/lambert.h"

namespace raylex::transport {

struct DiffuseTransmissionClosure {
    Rgb reflectance, transmittance;
    Sides sides = Sides::both;

    [[nodiscard]] bool is_black() const { return reflectance.is_black() && transmittance.is_black(); }
    [[nodiscard]] static constexpr bool has_density() { return true; }
    /// By the largest colours, as in pbrt-v4: then no colour's weight is above the sum of both.
    [[nodiscard]] Real reflection_probability() const {
        return reflection_chance(reflectance.max() / (reflectance.max() + transmittance.max()), sides);
    }
    [[nodiscard]] Rgb value(const Vec3& wo, const Vec3& wi) const {
        return (wo.z * wi.z > 0 ? reflectance : transmittance) * (wo.z == 0 ? 0 : std::abs(wi.z) * inv_pi);
    }
    [[nodiscard]] static constexpr LobeId lobe(bool transmitted) {
        return transmitted ? lobes::diffuse_transmit : lobes::diffuse;
    }
    [[nodiscard]] BsdfEvaluation evaluate(const Vec3& wo, const Vec3& wi) const {
        return one_lobe(lobe(!(wo.z * wi.z > 0)), value(wo, wi), pdf(wo, wi));
    }
    [[nodiscard]] BsdfSample sample(const Vec3& wo, Real u_lobe, const Vec2& u) const {
        const Real p = reflection_probability();
        LocalSample s = LambertClosure{}.draw(wo, u);
        s.transmitted = !(u_lobe < p);
        if (s.transmitted) s.wi.z = -s.wi.z;
        s.pdf *= s.transmitted ? 1 - p : p;
        s.weight = s.transmitted ? transmittance / (1 - p) : reflectance / p;
        return one_lobe(lobe(s.transmitted), s);
    }
    [[nodiscard]] Real pdf(const Vec3& wo, const Vec3& wi) const {
        if (wo.z == 0 || wi.z == 0) return 0;
        const Real p = reflection_probability();
        return (wo.z * wi.z > 0 ? p : 1 - p) * std::abs(wi.z) * inv_pi;
    }
    [[nodiscard]] Rgb albedo(const Vec3&) const { return reflectance + transmittance; }
    [[nodiscard]] static SideLobes side_lobes() { return {lobe(false), {lobe(true), lobe(true)}}; }
};

}  // namespace raylex::transport
