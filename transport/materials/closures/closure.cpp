#include "transport/materials/closures/closure.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <type_traits>
#include <vector>

namespace raylex::transport {

static_assert(sizeof(Bsdf) <= 256 && std::is_trivially_copyable_v<Bsdf>, "closures are copied in batches");

namespace {

std::vector<LobeKind>& all_lobes() {
    static std::vector<LobeKind> kinds(lobes::kinds.begin(), lobes::kinds.end());
    return kinds;
}

BsdfEvaluation one_lobe(LobeId lobe, const Rgb& value, Real pdf) {
    BsdfEvaluation result;
    if (!(pdf > 0)) return result;
    result.value = value;
    result.pdf = pdf;
    result.lobes.add(lobe, value);
    return result;
}

/// The one place where lobes become a value: their sum, in order (Law 5's bookkeeping).
BsdfEvaluation two_lobes(LobeId first, const Rgb& a, LobeId second, const Rgb& b, Real pdf) {
    BsdfEvaluation result;
    if (!(pdf > 0)) return result;
    result.value = a + b;
    result.pdf = pdf;
    result.lobes.add(first, a);
    result.lobes.add(second, b);
    return result;
}

BsdfSample to_sample(const Frame& frame, const LocalSample& s, LobeId lobe) {
    BsdfSample result;
    if (!(s.pdf > 0)) return result;
    result.wi = frame.to_world(s.wi);
    result.weight = s.weight;
    result.pdf = s.pdf;
    result.eta = s.eta;
    result.delta = s.delta;
    result.transmitted = s.transmitted;
    result.lobes.add(lobe, s.weight * s.pdf);
    return result;
}

LobeId glass_lobe(bool transmitted, bool delta) {
    if (transmitted) return delta ? lobes::glass_transmit_singular : lobes::glass_transmit_glossy;
    return delta ? lobes::glass_reflect_singular : lobes::glass_reflect_glossy;
}

LobeId subsurface_lobe(bool transmitted, bool delta) {
    if (transmitted) return lobes::subsurface;
    return delta ? lobes::specular_singular : lobes::specular_glossy;
}

LobeId conductor_lobe(bool delta) {
    return delta ? lobes::conductor_singular : lobes::conductor_glossy;
}

template <class Base>
LobeId base_lobe(bool delta) {
    if constexpr (std::is_same_v<Base, LambertClosure>) return lobes::diffuse;
    else return conductor_lobe(delta);
}

template <class Base>
BsdfEvaluation evaluate_layered(const LayeredClosure<Base>& layered, const Vec3& wo, const Vec3& wi, std::uint32_t key,
                                Sides sides) {
    const Real pdf = layered.pdf(wo, wi, sides);
    if (!(pdf > 0)) return {};
    if (sides == Sides::reflection) return one_lobe(lobes::coat_glossy, Rgb(layered.coat_value(wo, wi)), pdf);
    const Rgb entered = layered.base_value(wo, wi, key);
    if (layered.coat.interface.is_delta() || sides == Sides::transmission)
        return one_lobe(base_lobe<Base>(false), entered, pdf);
    return two_lobes(lobes::coat_glossy, Rgb(layered.coat_value(wo, wi)), base_lobe<Base>(false), entered, pdf);
}

template <class Base>
BsdfSample sample_layered(const Frame& frame, const LayeredClosure<Base>& layered, const Vec3& wo, Real u_lobe,
                          const Vec2& u, std::uint32_t key, Sides sides) {
    const LayeredSample walk = layered.sample(wo, u_lobe, u, key, sides);
    const bool delta = walk.scatter.delta;
    const LobeId coat = delta ? lobes::coat_singular : lobes::coat_glossy;
    BsdfSample result = to_sample(frame, walk.scatter, walk.entered ? base_lobe<Base>(delta) : coat);
    result.pdf_is_proportional = !delta;
    return result;
}

BsdfEvaluation evaluate_additive(const AdditiveClosure& closure, const Vec3& wo, const Vec3& wi) {
    Real specular_pdf;
    const Rgb specular = closure.specular.value_and_pdf(wo, wi, specular_pdf);
    const Real p = closure.diffuse_probability();
    const Real pdf = p * LambertClosure::pdf(wo, wi) + (1 - p) * specular_pdf;
    return two_lobes(lobes::diffuse, closure.diffuse.value(wo, wi), lobes::specular_glossy, specular, pdf);
}

BsdfSample sample_additive(const Frame& frame, const AdditiveClosure& closure, const Vec3& wo, Real u_lobe,
                           const Vec2& u) {
    BsdfSample result;
    Vec3 wi;
    if (!closure.sample_direction(wo, u_lobe, u, wi)) return result;
    const BsdfEvaluation all = evaluate_additive(closure, wo, wi);
    if (!(all.pdf > 0)) return result;
    result.wi = frame.to_world(wi);
    result.weight = all.value / all.pdf;
    result.pdf = all.pdf;
    result.lobes = all.lobes;
    return result;
}

BsdfSample sample_ideal(const Frame& frame, const IdealClosure& closure, const Vec3& wo, Real u_lobe, const Vec2& u) {
    static constexpr LobeId lobe_of[] = {lobes::diffuse, lobes::mirror, lobes::sheet};
    int lobe = 0;
    const LocalSample s = closure.sample(wo, u_lobe, u, lobe);
    return to_sample(frame, s, lobe_of[lobe]);
}

Real ideal_pdf(const IdealClosure& closure, const Vec3& wo, const Vec3& wi) {
    if (closure.diffuse.is_black() || std::abs(wo.z) < min_cosine) return 0;
    return closure.diffuse_probability() * LambertClosure::pdf(wo, wi);
}

BsdfSample draw_phase(Real g, const Vec3& wo, const Vec2& u) {
    const PhaseSample phase = sample_phase(g, -wo, u);
    BsdfSample result;
    result.wi = phase.wi;
    result.weight = Rgb(1);
    result.pdf = phase.pdf;
    result.lobes.add(lobes::diffuse, Rgb(phase.pdf));
    return result;
}

}  // namespace

std::span<const LobeKind> lobe_kinds() {
    return all_lobes();
}

std::optional<LobeId> add_lobe(const LobeKind& lobe) {
    std::vector<LobeKind>& kinds = all_lobes();
    const auto known = std::find_if(kinds.begin(), kinds.end(), [&](const LobeKind& each) {
        return each.type == lobe.type && each.scatter == lobe.scatter && std::string_view(each.name) == lobe.name;
    });
    if (known != kinds.end()) return static_cast<LobeId>(known - kinds.begin());
    if (kinds.size() > std::numeric_limits<LobeId>::max()) return std::nullopt;
    kinds.push_back(lobe);
    return static_cast<LobeId>(kinds.size() - 1);
}

std::optional<SideLobes> Bsdf::side_lobes() const {
    switch (kind_) {
        case Kind::dielectric: {
            const bool delta = dielectric_.is_delta();
            return SideLobes{glass_lobe(false, delta), {glass_lobe(true, delta), glass_lobe(true, delta)}};
        }
        case Kind::subsurface:
            return SideLobes{subsurface_lobe(false, dielectric_.is_delta()), {lobes::subsurface, lobes::subsurface}};
        case Kind::thin_dielectric:
            return SideLobes{glass_lobe(false, true), {glass_lobe(true, true), glass_lobe(true, true)}};
        case Kind::coated_diffuse: {
            const bool delta = coated_diffuse_.coat.interface.is_delta();
            return SideLobes{delta ? lobes::coat_singular : lobes::coat_glossy, {lobes::diffuse, lobes::diffuse}};
        }
        case Kind::coated_conductor: {
            // A medium between them makes a density of some of what a mirror would send in one direction.
            const bool delta = coated_conductor_.coat.interface.is_delta();
            return SideLobes{delta ? lobes::coat_singular : lobes::coat_glossy,
                             {lobes::conductor_singular, lobes::conductor_glossy}};
        }
        case Kind::diffuse_transmission:
            return SideLobes{lobes::diffuse, {lobes::diffuse_transmit, lobes::diffuse_transmit}};
        default:
            return std::nullopt;
    }
}

void Bsdf::keep_side(Sides side) {
    sides_ = side;
    if (side != Sides::reflection) return;
    if (kind_ == Kind::coated_diffuse && coated_diffuse_.coat.interface.is_delta()) has_density_ = false;
    if (kind_ == Kind::coated_conductor && coated_conductor_.coat.interface.is_delta()) has_density_ = false;
}

void Bsdf::set_index(Real inside) {
    if (kind_ == Kind::compensated_dielectric) {
        compensated_dielectric_.glass.eta = inside;
    } else if (kind_ == Kind::dielectric || kind_ == Kind::subsurface) {
        dielectric_.eta = inside;
        has_density_ = !dielectric_.is_delta();
    }
}

bool Bsdf::reflects_all_alike(const IndexSpectrum& indices, const Vec3& wo) const {
    if ((kind_ != Kind::dielectric && kind_ != Kind::subsurface) || !dielectric_.facets.smooth()) return false;
    return dot(wo, frame_.n) > 0 ? indices.least() > 1 : indices.most() < 1;
}

Rgb Bsdf::reflected_colours(const Rgb& inside, const Vec3& wo) const {
    const Real cos_o = dot(wo, frame_.n);
    const auto share = [&](Real index) { return fresnel_dielectric(std::abs(cos_o), cos_o > 0 ? index : 1 / index); };
    return Rgb(share(inside.r), share(inside.g), share(inside.b)) / share(dielectric_.eta);
}

BsdfEvaluation Bsdf::evaluate_other(const Vec3& wo_world, const Vec3& wi_world) const {
    if (!has_density_) return {};
    if (kind_ == Kind::phase) {
        const Real phase = phase_pdf(phase_g_, -wo_world, wi_world);
        return one_lobe(lobes::diffuse, Rgb(phase), phase);
    }
    const Vec3 wo = frame_.to_local(wo_world), wi = frame_.to_local(wi_world);
    switch (kind_) {
        case Kind::conductor: {
            Real pdf;
            const Rgb value = conductor_.value_and_pdf(wo, wi, pdf);
            return one_lobe(lobes::conductor_glossy, value, pdf);
        }
        case Kind::dielectric:
        case Kind::subsurface: {
            const bool crossed = wo.z * wi.z < 0;
            return one_lobe(kind_ == Kind::dielectric ? glass_lobe(crossed, false) : subsurface_lobe(crossed, false),
                            Rgb(dielectric_.value(wo, wi, TransportMode::radiance)), dielectric_.pdf(wo, wi, sides_));
        }
        case Kind::compensated_conductor: {
            Real pdf;
            const Rgb value = compensated_conductor_.value_and_pdf(wo, wi, pdf);
            return one_lobe(lobes::conductor_glossy, value, pdf);
        }
        case Kind::compensated_dielectric:
            return one_lobe(glass_lobe(wo.z * wi.z < 0, false), Rgb(compensated_dielectric_.value(wo, wi)),
                            compensated_dielectric_.glass.pdf(wo, wi, Sides::both));
        case Kind::coated_diffuse:
            return evaluate_layered(coated_diffuse_, wo, wi, key_, sides_);
        case Kind::coated_conductor:
            return evaluate_layered(coated_conductor_, wo, wi, key_, sides_);
        case Kind::additive:
            return evaluate_additive(additive_, wo, wi);
        case Kind::ideal:
            return one_lobe(lobes::diffuse, LambertClosure{ideal_.diffuse}.value(wo, wi), ideal_pdf(ideal_, wo, wi));
        case Kind::diffuse_transmission:
            return one_lobe(wo.z * wi.z > 0 ? lobes::diffuse : lobes::diffuse_transmit,
                            diffuse_transmission_.value(wo, wi), diffuse_transmission_.pdf(wo, wi, sides_));
        case Kind::hair:
            return hair_.evaluate(wo, wi);
        case Kind::measured:
            return one_lobe(lobes::measured, measured_.table->value(wo, wi), measured_.table->pdf(wo, wi));
        case Kind::custom:
            return custom_.calls->evaluate(custom_.data.data(), wo, wi);
        case Kind::black:
        case Kind::pass_through:
        case Kind::lambert:
        case Kind::thin_dielectric:
        case Kind::phase:
            break;
    }
    return {};
}

Real Bsdf::pdf_other(const Vec3& wo_world, const Vec3& wi_world) const {
    if (!has_density_) return 0;
    if (kind_ == Kind::phase) return phase_pdf(phase_g_, -wo_world, wi_world);
    const Vec3 wo = frame_.to_local(wo_world), wi = frame_.to_local(wi_world);
    switch (kind_) {
        case Kind::conductor:
            return conductor_.pdf(wo, wi);
        case Kind::dielectric:
        case Kind::subsurface:
            return dielectric_.pdf(wo, wi, sides_);
        case Kind::compensated_conductor:
            return compensated_conductor_.metal.pdf(wo, wi);
        case Kind::compensated_dielectric:
            return compensated_dielectric_.glass.pdf(wo, wi, Sides::both);
        case Kind::coated_diffuse:
            return coated_diffuse_.pdf(wo, wi, sides_);
        case Kind::coated_conductor:
            return coated_conductor_.pdf(wo, wi, sides_);
        case Kind::additive:
            return evaluate_additive(additive_, wo, wi).pdf;
        case Kind::ideal:
            return ideal_pdf(ideal_, wo, wi);
        case Kind::diffuse_transmission:
            return diffuse_transmission_.pdf(wo, wi, sides_);
        case Kind::hair:
            return hair_.pdf(wo, wi);
        case Kind::measured:
            return measured_.table->pdf(wo, wi);
        case Kind::custom:
            return custom_.calls->pdf(custom_.data.data(), wo, wi);
        case Kind::black:
        case Kind::pass_through:
        case Kind::lambert:
        case Kind::thin_dielectric:
        case Kind::phase:
            break;
    }
    return 0;
}

BsdfSample Bsdf::sample_other(const Vec3& wo, Real u_lobe, const Vec2& u) const {
    BsdfSample s = draw(wo, u_lobe, u);
    if (!(s.pdf > 0) || s.delta || s.pdf_is_proportional || kind_ == Kind::phase) return s;
    // Turning a direction to world space rounds it. Where the density is steep, on narrow lobes and near the horizon,
    // that of the direction drawn is not that of the direction given.
    const Real pdf = pdf_other(wo, s.wi), change = pdf / s.pdf;  // facets are drawn with a pdf of 1
    s.pdf = pdf;
    for (int l = 0; l < s.lobes.count; ++l) s.lobes.entry[static_cast<std::size_t>(l)].value *= change;
    return s;
}

BsdfSample Bsdf::draw(const Vec3& wo_world, Real u_lobe, const Vec2& u) const {
    if (kind_ == Kind::black || kind_ == Kind::pass_through) return {};
    if (kind_ == Kind::phase) return draw_phase(phase_g_, wo_world, u);
    const Vec3 wo = frame_.to_local(wo_world);
    switch (kind_) {
        case Kind::conductor:
            return to_sample(frame_, conductor_.draw(wo, u, false), conductor_lobe(conductor_.is_delta()));
        case Kind::dielectric:
        case Kind::subsurface: {
            const LocalSample s = dielectric_.draw(wo, u_lobe, u, TransportMode::radiance, sides_, false);
            return to_sample(frame_, s,
                             kind_ == Kind::dielectric ? glass_lobe(s.transmitted, s.delta)
                                                       : subsurface_lobe(s.transmitted, s.delta));
        }
        case Kind::thin_dielectric: {
            const LocalSample s = thin_dielectric_.sample(wo, u_lobe, sides_);
            return to_sample(frame_, s, glass_lobe(s.transmitted, true));
        }
        case Kind::compensated_conductor:
            return to_sample(frame_, compensated_conductor_.draw(wo, u), lobes::conductor_glossy);
        case Kind::compensated_dielectric: {
            const LocalSample s = compensated_dielectric_.draw(wo, u_lobe, u);
            return to_sample(frame_, s, glass_lobe(s.transmitted, false));
        }
        case Kind::coated_diffuse:
            return sample_layered(frame_, coated_diffuse_, wo, u_lobe, u, key_, sides_);
        case Kind::coated_conductor:
            return sample_layered(frame_, coated_conductor_, wo, u_lobe, u, key_, sides_);
        case Kind::additive:
            return sample_additive(frame_, additive_, wo, u_lobe, u);
        case Kind::ideal:
            return sample_ideal(frame_, ideal_, wo, u_lobe, u);
        case Kind::diffuse_transmission: {
            const LocalSample s = diffuse_transmission_.sample(wo, u_lobe, u, sides_);
            return to_sample(frame_, s, s.transmitted ? lobes::diffuse_transmit : lobes::diffuse);
        }
        case Kind::measured:
            return to_sample(frame_, measured_.table->sample(wo, u), lobes::measured);
        case Kind::hair: {
            BsdfSample result = hair_.sample(wo, u_lobe, u);
            result.wi = frame_.to_world(result.wi);
            return result;
        }
        case Kind::custom: {
            BsdfSample result = custom_.calls->sample(custom_.data.data(), wo, u_lobe, u);
            result.wi = frame_.to_world(result.wi);
            return result;
        }
        case Kind::black:
        case Kind::pass_through:
        case Kind::lambert:
        case Kind::phase:
            break;
    }
    return {};
}

void Bsdf::regularize() {
    const auto blur = [](auto& closure) {
        closure.facets = closure.facets.regularized();
        return !closure.is_delta();
    };
    switch (kind_) {
        case Kind::conductor:
            has_density_ = blur(conductor_);
            break;
        case Kind::dielectric:
        case Kind::subsurface:
            has_density_ = blur(dielectric_);
            break;
        case Kind::coated_diffuse:
            blur(coated_diffuse_.coat.interface);
            break;
        case Kind::coated_conductor:
            blur(coated_conductor_.coat.interface);
            blur(coated_conductor_.base);
            has_density_ = !coated_conductor_.is_delta();
            break;
        default:
            break;
    }
}

Rgb Bsdf::albedo(const Vec3& wo) const {
    const Real cos_o = std::abs(dot(wo, frame_.n));
    switch (kind_) {
        case Kind::lambert:
            return lambert_.reflectance;
        case Kind::conductor:
            return conductor_.albedo(cos_o);
        case Kind::dielectric:
        case Kind::subsurface:
        case Kind::thin_dielectric:
            return Rgb(1);
        case Kind::compensated_conductor:
            return compensated_conductor_.albedo(frame_.to_local(wo));
        case Kind::compensated_dielectric:
            return Rgb(1);
        case Kind::coated_diffuse:
            return coated_diffuse_.albedo(cos_o);
        case Kind::coated_conductor:
            return coated_conductor_.albedo(cos_o);
        case Kind::additive:
            return additive_.diffuse.reflectance + additive_.specular.albedo(cos_o);
        case Kind::ideal:
            return ideal_.diffuse + ideal_.mirror + ideal_.sheet;
        case Kind::diffuse_transmission:
            return diffuse_transmission_.reflectance + diffuse_transmission_.transmittance;
        case Kind::measured:
            return measured_.table->albedo(cos_o);
        case Kind::hair:
            return hair_.albedo(frame_.to_local(wo));
        case Kind::custom:
            return custom_.calls->albedo(custom_.data.data(), cos_o);
        case Kind::black:
        case Kind::pass_through:
        case Kind::phase:
            break;
    }
    return {};
}

}  // namespace raylex::transport
