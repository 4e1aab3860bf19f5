#include "transport/materials/bsdf/dielectric.h"

namespace raylex::transport {

namespace {

/// The view from wo's side: directions mirrored so that wo is above, and the index seen from there.
struct View {
    bool below;
    Real eta;

    View(Real wo_z, Real eta_inside) : below(wo_z < 0), eta(below ? 1 / eta_inside : eta_inside) {}
    [[nodiscard]] Vec3 turn(const Vec3& w) const { return below ? -w : w; }
};

Real radiance_scale(TransportMode mode, Real eta) {
    return mode == TransportMode::radiance ? 1 / (eta * eta) : 1.0f;
}

/// What value and density have in common for a pair of directions, wo above the surface.
struct Pair {
    bool valid = false, reflected = false;
    Real fresnel = 0, d = 0;
    Real jacobian = 0;  // |d m / d wi| times wo.m / wo.z: what turns G1 D into a density of wi

    Pair(const Ggx& facets, const Vec3& wo, const Vec3& wi, Real eta) {
        if (wo.z < min_cosine || std::abs(wi.z) < min_cosine) return;
        reflected = wi.z > 0;
        // wo + eta wi; their sum first, which is exact where they are nearly opposite.
        Vec3 m = wo + wi;
        if (!reflected) m += wi * (eta - 1);
        const Real l2 = length_squared(m);
        if (!(l2 > 0)) return;
        m = m / std::sqrt(l2);
        if (m.z < 0) m = -m;
        const Real om = dot(wo, m), im = dot(wi, m);
        if (!(om > 0) || (reflected ? !(im > 0) : !(im < 0))) return;  // seen from a facet's back
        valid = true;
        fresnel = fresnel_dielectric(om, eta);
        d = facets.d(m);
        // Walter et al. (14), (17); the first factor of reflection is om / (4 om).
        jacobian = reflected ? 0.25f / wo.z : om * -im / (wo.z * square(im + om / eta));
    }
};

}  // namespace

Real DielectricClosure::value(Vec3 wo, Vec3 wi, TransportMode mode) const {
    if (is_delta()) return 0;
    const View view(wo.z, eta);
    wo = view.turn(wo);
    wi = view.turn(wi);
    const Pair pair(facets, wo, wi, view.eta);
    if (!pair.valid) return 0;
    const Real masked = pair.d * pair.jacobian * facets.g2(wo, {wi.x, wi.y, std::abs(wi.z)});
    return pair.reflected ? pair.fresnel * masked : (1 - pair.fresnel) * masked * radiance_scale(mode, view.eta);
}

Real DielectricClosure::pdf(Vec3 wo, Vec3 wi, Sides sides) const {
    if (is_delta()) return 0;
    const View view(wo.z, eta);
    wo = view.turn(wo);
    const Pair pair(facets, wo, view.turn(wi), view.eta);
    if (!pair.valid) return 0;
    const Real reflect_chance = reflection_chance(pair.fresnel, sides);
    return (pair.reflected ? reflect_chance : 1 - reflect_chance) * facets.g1(wo) * pair.d * pair.jacobian;
}

LocalSample DielectricClosure::draw(const Vec3& wo, Real u_lobe, const Vec2& u, TransportMode mode, Sides sides,
                                    bool density) const {
    if (std::abs(wo.z) < min_cosine) return {};
    return is_delta() ? draw_ideal(wo, u_lobe, mode, sides) : draw_rough(wo, u_lobe, u, mode, sides, density);
}

LocalSample DielectricClosure::draw_ideal(const Vec3& wo, Real u_lobe, TransportMode mode, Sides sides) const {
    LocalSample s;
    const View view(wo.z, eta);
    const Real cos_o = std::abs(wo.z), fresnel = fresnel_dielectric(cos_o, view.eta);
    const Real reflect_chance = reflection_chance(fresnel, sides);
    s.delta = true;
    if (u_lobe < reflect_chance) {
        s.wi = {-wo.x, -wo.y, wo.z};
        s.pdf = reflect_chance;
        s.weight = Rgb(fresnel / reflect_chance);
        return s;
    }
    const Real cos2_t = refracted_cosine_squared(cos_o, view.eta);
    if (cos2_t <= 0) return s;  // only transmission is allowed, and there is none
    const Real cos_t = std::copysign(std::sqrt(cos2_t), -wo.z);
    s.wi = {-wo.x / view.eta, -wo.y / view.eta, cos_t};
    s.pdf = 1 - reflect_chance;
    s.weight = Rgb((1 - fresnel) / s.pdf * radiance_scale(mode, view.eta));
    s.eta = view.eta;
    s.transmitted = true;
    return s;
}

LocalSample DielectricClosure::draw_rough(const Vec3& wo_given, Real u_lobe, const Vec2& u, TransportMode mode,
                                          Sides sides, bool density) const {
    LocalSample s;
    const View view(wo_given.z, eta);
    const Vec3 wo = view.turn(wo_given);
    const Vec3 m = facets.sample_visible_normal(wo, u);
    const Real om = dot(wo, m);
    if (!(om > 0)) return s;
    const Real fresnel = fresnel_dielectric(om, view.eta), reflect_chance = reflection_chance(fresnel, sides);
    const Real lambda_o = facets.lambda(wo);
    const Real visible = density ? facets.d(m) / (1 + lambda_o) / wo.z : 0;  // times om: the density of m
    Vec3 wi;
    if (u_lobe < reflect_chance) {
        wi = reflect(wo, m);
        if (wi.z < min_cosine) return s;
        s.pdf = reflect_chance * visible * 0.25f;
        s.weight = Rgb(fresnel / reflect_chance);
    } else {
        const Real cos2_t = refracted_cosine_squared(om, view.eta);
        if (cos2_t <= 0) return s;
        const Real cos_t = std::sqrt(cos2_t);
        wi = m * (om / view.eta - cos_t) - wo / view.eta;
        if (wi.z > -min_cosine) return s;
        s.pdf = (1 - reflect_chance) * visible * om * cos_t / square(om / view.eta - cos_t);
        s.weight = Rgb((1 - fresnel) / (1 - reflect_chance) * radiance_scale(mode, view.eta));
        s.eta = view.eta;
        s.transmitted = true;
    }
    if (!density) s.pdf = 1;
    const Real lambda_i = facets.lambda({wi.x, wi.y, std::abs(wi.z)});
    s.weight *= (1 + lambda_o) / (1 + lambda_o + lambda_i);
    s.wi = view.turn(wi);
    return s;
}

BsdfSample ThinDielectricClosure::sample(const Vec3& wo, Real u_lobe, const Vec2&) const {
    LocalSample s;
    if (std::abs(wo.z) < min_cosine) return {};
    const Real r = reflectance(std::abs(wo.z)), reflect_chance = reflection_chance(r, sides);
    s.delta = true;
    s.transmitted = !(u_lobe < reflect_chance);
    s.wi = s.transmitted ? -wo : Vec3{-wo.x, -wo.y, wo.z};
    s.pdf = s.transmitted ? 1 - reflect_chance : reflect_chance;
    s.weight = sides == Sides::both ? Rgb(1) : Rgb(s.transmitted ? 1 - r : r);
    return one_lobe(lobes::glass(s.transmitted, true), s);
}

}  // namespace raylex::transport
