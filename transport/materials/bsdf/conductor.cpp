#include "transport/materials/bsdf/conductor.h"

namespace raylex::transport {

bool to_upper_side(Vec3& wo, Vec3& wi) {
    if (wo.z < 0) {
        wo = -wo;
        wi = -wi;
    }
    return wo.z >= min_cosine && wi.z >= min_cosine;
}

Rgb ConductorClosure::value_and_pdf(Vec3 wo, Vec3 wi, Real& pdf) const {
    pdf = 0;
    if (is_delta() || !to_upper_side(wo, wi)) return {};
    const Vec3 m = normalize(wo + wi);
    const Real d = facets.d(m), lambda_o = facets.lambda(wo), lambda_i = facets.lambda(wi);
    const Real scale = d / (4 * wo.z);  // Jacobian 1 / (4 wo.m) and the cosines cancelled
    pdf = scale / (1 + lambda_o);
    return fresnel(dot(wo, m)) * (scale / (1 + lambda_o + lambda_i));
}

Rgb ConductorClosure::value(Vec3 wo, Vec3 wi) const {
    Real unused;
    return value_and_pdf(wo, wi, unused);
}

Real ConductorClosure::pdf(Vec3 wo, Vec3 wi) const {
    if (is_delta() || !to_upper_side(wo, wi)) return 0;
    return facets.d(normalize(wo + wi)) / (4 * wo.z) / (1 + facets.lambda(wo));  // the same bits as value_and_pdf()
}

LocalSample ConductorClosure::draw(Vec3 wo, const Vec2& u, bool density) const {
    LocalSample s;
    if (std::abs(wo.z) < min_cosine) return s;
    if (is_delta()) {
        s.wi = {-wo.x, -wo.y, wo.z};
        s.weight = fresnel(std::abs(wo.z));
        s.pdf = 1;
        s.delta = true;
        return s;
    }
    const bool below = wo.z < 0;
    if (below) wo = -wo;
    const Vec3 m = facets.sample_visible_normal(wo, u);
    const Vec3 wi = reflect(wo, m);
    if (wi.z < min_cosine) return s;
    const Real lambda_o = facets.lambda(wo), lambda_i = facets.lambda(wi);
    s.wi = below ? -wi : wi;
    s.pdf = density ? facets.d(m) / (4 * wo.z * (1 + lambda_o)) : 1;
    // Everything but Fresnel and the masking of wi cancels: the weight is at most 1 at any angle.
    s.weight = fresnel(dot(wo, m)) * ((1 + lambda_o) / (1 + lambda_o + lambda_i));
    return s;
}

}  // namespace raylex::transport
