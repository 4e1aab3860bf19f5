#include "transport/materials/closures/ideal.h"

namespace raylex::transport {

LocalSample IdealClosure::sample(const Vec3& wo, Real u_lobe, const Vec2& u, int& lobe) const {
    LocalSample s;
    lobe = 0;
    const Real sum = total();
    if (!(sum > 0) || std::abs(wo.z) < min_cosine) return s;
    const Real p_diffuse = diffuse.average() / sum, p_mirror = mirror.average() / sum;
    if (u_lobe < p_diffuse) {
        s = LambertClosure{diffuse}.sample(wo, 0, u);
        s.pdf *= p_diffuse;
        s.weight = diffuse / p_diffuse;
        return s;
    }
    s.delta = true;
    // Rounding may leave a sliver above the last lobe's chance: it belongs to the last lobe there is.
    if (u_lobe < p_diffuse + p_mirror || sheet.is_black()) {
        if (mirror.is_black()) return s;
        lobe = 1;
        s.wi = {-wo.x, -wo.y, wo.z};
        s.pdf = p_mirror;
        s.weight = mirror / p_mirror;
        return s;
    }
    lobe = 2;
    s.wi = -wo;
    s.pdf = sheet.average() / sum;
    s.weight = sheet / s.pdf;
    s.transmitted = true;
    return s;
}

Real AdditiveClosure::diffuse_probability() const {
    const Real kd = diffuse.reflectance.average(), ks = specular.fresnel(1).average();
    return kd + ks > 0 ? kd / (kd + ks) : 1.0f;
}

bool AdditiveClosure::sample_direction(const Vec3& wo, Real u_lobe, const Vec2& u, Vec3& wi) const {
    if (std::abs(wo.z) < min_cosine) return false;
    const LocalSample s = u_lobe < diffuse_probability() ? diffuse.sample(wo, 0, u) : specular.draw(wo, u, false);
    wi = s.wi;
    return s.pdf > 0;
}

}  // namespace raylex::transport
