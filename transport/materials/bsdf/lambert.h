// Ideal diffuse reflection, from both sides of the surface: f = reflectance / pi where wo and wi are on one side.
#pragma once

#include "transport/materials/bsdf/scatter.h"
#include "transport/math/sampling.h"

namespace raylex::transport {

struct LambertClosure {
    Rgb reflectance;

    [[nodiscard]] Rgb value(const Vec3& wo, const Vec3& wi) const { return reflectance * pdf(wo, wi); }
    [[nodiscard]] static Real pdf(const Vec3& wo, const Vec3& wi) {
        return wo.z * wi.z > 0 ? std::abs(wi.z) * inv_pi : 0.0f;
    }
    [[nodiscard]] LocalSample sample(const Vec3& wo, Real, const Vec2& u) const {
        LocalSample s;
        s.wi = sample_cosine_hemisphere(u);
        s.pdf = s.wi.z * inv_pi;
        s.weight = reflectance;
        if (wo.z < 0) s.wi.z = -s.wi.z;
        if (wo.z == 0) s.pdf = 0;
        return s;
    }
    [[nodiscard]] static constexpr bool is_delta() { return false; }
    [[nodiscard]] Rgb albedo(Real) const { return reflectance; }
};

}  // namespace raylex::transport
