// Ideal diffuse reflection, from both sides of the surface: f = reflectance / pi where wo and wi are on one side.
#pragma once

#include "transport/materials/bsdf/lobes.h"
#include "transport/materials/bsdf/scatter.h"
#include "transport/math/sampling.h"

namespace raylex::transport {

struct LambertClosure {
    Rgb reflectance;

    [[nodiscard]] bool is_black() const { return reflectance.is_black(); }
    [[nodiscard]] static constexpr bool has_density() { return true; }
    [[nodiscard]] Rgb albedo(const Vec3&) const { return reflectance; }
    void regularize() {}

    // As a surface of its own, in world space. Most vertices of most scenes are such surfaces, and a cosine needs no
    // tangents.

    [[nodiscard]] BsdfEvaluation evaluate(const Frame& frame, const Vec3& wo, const Vec3& wi) const {
        const Real density = pdf(frame, wo, wi);
        return one_lobe(lobes::diffuse, reflectance * density, density);
    }
    [[nodiscard]] static Real pdf(const Frame& frame, const Vec3& wo, const Vec3& wi) {
        const Real cos_i = dot(wi, frame.n);
        return cos_i * dot(wo, frame.n) > 0 ? std::abs(cos_i) * inv_pi : 0.0f;
    }
    [[nodiscard]] BsdfSample sample(const Frame& frame, const Vec3& wo, const Vec2& u) const {
        BsdfSample result;
        const Real cos_o = dot(wo, frame.n);
        if (cos_o == 0) return result;
        const Vec3 local = sample_cosine_hemisphere(u);
        result.wi = frame.to_world({local.x, local.y, std::copysign(local.z, cos_o)});
        const Real cos_i = dot(result.wi, frame.n);  // of the rounded direction, as pdf() computes it
        if (!(cos_i * cos_o > 0)) return result;
        result.pdf = std::abs(cos_i) * inv_pi;
        result.weight = reflectance;
        result.lobes.add(lobes::diffuse, reflectance * result.pdf);
        return result;
    }

    // As a part of other closures, in the shading frame.

    [[nodiscard]] static constexpr LobeId lobe(bool) { return lobes::diffuse; }
    [[nodiscard]] Rgb value(const Vec3& wo, const Vec3& wi) const { return reflectance * pdf(wo, wi); }
    [[nodiscard]] static Real pdf(const Vec3& wo, const Vec3& wi) {
        return wo.z * wi.z > 0 ? std::abs(wi.z) * inv_pi : 0.0f;
    }
    [[nodiscard]] LocalSample draw(const Vec3& wo, const Vec2& u) const {
        LocalSample s;
        s.wi = sample_cosine_hemisphere(u);
        s.pdf = s.wi.z * inv_pi;
        s.weight = reflectance;
        if (wo.z < 0) s.wi.z = -s.wi.z;
        if (wo.z == 0) s.pdf = 0;
        return s;
    }
};

}  // namespace raylex::transport
