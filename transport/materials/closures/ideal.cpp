#include "transport/materials/closures/ideal.h"

namespace raylex::transport {

BsdfSample IdealClosure::sample(const Vec3& wo, Real u_lobe, const Vec2& u) const {
    const Real sum = total();
    if (!(sum > 0) || std::abs(wo.z) < min_cosine) return {};
    const Real p_diffuse = diffuse.average() / sum, p_mirror = mirror.average() / sum;
    LocalSample s;
    if (u_lobe < p_diffuse) {
        s = LambertClosure{diffuse}.draw(wo, u);
        s.pdf *= p_diffuse;
        s.weight = diffuse / p_diffuse;
        return one_lobe(lobes::diffuse, s);
    }
    s.delta = true;
    // Rounding may leave a sliver above the last lobe's chance: it belongs to the last lobe that is not black.
    if (u_lobe < p_diffuse + p_mirror || sheet.is_black()) {
        if (mirror.is_black()) return {};
        s.wi = {-wo.x, -wo.y, wo.z};
        s.pdf = p_mirror;
        s.weight = mirror / p_mirror;
        return one_lobe(lobes::mirror, s);
    }
    s.wi = -wo;
    s.pdf = sheet.average() / sum;
    s.weight = sheet / s.pdf;
    s.transmitted = true;
    return one_lobe(lobes::sheet, s);
}

Real IdealClosure::pdf(const Vec3& wo, const Vec3& wi) const {
    if (diffuse.is_black() || std::abs(wo.z) < min_cosine) return 0;
    return diffuse.average() / total() * LambertClosure::pdf(wo, wi);
}

Real AdditiveClosure::diffuse_probability() const {
    const Real kd = diffuse.reflectance.average(), ks = specular.fresnel(1).average();
    return kd + ks > 0 ? kd / (kd + ks) : 1.0f;
}

BsdfEvaluation AdditiveClosure::evaluate(const Vec3& wo, const Vec3& wi) const {
    Real specular_pdf;
    const Rgb reflected = specular.value_and_pdf(wo, wi, specular_pdf);
    const Real p = diffuse_probability();
    return two_lobes(lobes::diffuse, diffuse.value(wo, wi), lobes::specular_glossy, reflected,
                     p * LambertClosure::pdf(wo, wi) + (1 - p) * specular_pdf);
}

BsdfSample AdditiveClosure::sample(const Vec3& wo, Real u_lobe, const Vec2& u) const {
    if (std::abs(wo.z) < min_cosine) return {};
    const LocalSample s = u_lobe < diffuse_probability() ? diffuse.draw(wo, u) : specular.draw(wo, u, false);
    if (!(s.pdf > 0)) return {};
    return sample_of(s.wi, evaluate(wo, s.wi));
}

}  // namespace raylex::transport
