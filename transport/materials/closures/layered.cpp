#include "transport/materials/closures/layered.h"

#include <bit>
#include <type_traits>

#include "display/services/elementary.h"
#include "display/services/split_mix.h"
#include "transport/materials/bsdf/conductor.h"
#include "transport/materials/bsdf/lambert.h"
#include "transport/media/phase.h"

namespace raylex::transport {

namespace {

/// Counter-based random numbers of one walk (SplitMix64).
class WalkRandom {
  public:
    WalkRandom(std::uint32_t key, const Vec3& a, const Vec3& b) : state_(mix_bits(key + 0x6c61796572ull)) {
        absorb(a.x, a.y);
        absorb(a.z, b.x);
        absorb(b.y, b.z);
    }
    Real one() { return unit_float(mix_bits(state_ += golden_gamma)); }
    Vec2 two() {
        const Real x = one();
        return {x, one()};
    }

  private:
    void absorb(Real a, Real b) {
        state_ = mix_bits(state_ ^ (std::uint64_t{std::bit_cast<std::uint32_t>(to_float(a))} << 32 |
                                    std::bit_cast<std::uint32_t>(to_float(b))));
    }
    std::uint64_t state_;
};

Real transmittance(Real depth, const Vec3& w) {
    return elementary::exp(-std::abs(depth / w.z));
}

/// Where a walk stands: height above the base, direction of travel.
struct WalkPoint {
    Real z;
    Vec3 w;
};

enum class Advance : std::uint8_t { interface, scattered, stuck };

/// Moves to the next interface or, in a scattering medium, to an event before it. Absorption is multiplied to `beta`.
Advance advance(const CoatLayer& coat, WalkPoint& at, Rgb& beta, WalkRandom& random) {
    if (at.w.z == 0) return Advance::stuck;
    const Real boundary = at.w.z > 0 ? coat.thickness : 0;
    if (coat.albedo.is_black()) {
        beta *= transmittance(coat.thickness, at.w);
        at.z = boundary;
        return Advance::interface;
    }
    const Real z = at.z - elementary::log1p(-random.one()) * at.w.z;  // w is unit: distance times w.z is height
    if (z == at.z) return Advance::stuck;
    if (z > 0 && z < coat.thickness) {
        at.z = z;
        return Advance::scattered;
    }
    at.z = boundary;
    return Advance::interface;
}

/// Russian roulette from the fifth layer on. False when the walk ends.
bool survives(int depth, Rgb& beta, Real& pdf, WalkRandom& random) {
    const Real strongest = beta.max();
    if (depth <= 3 || strongest >= 0.25f) return strongest > 0;
    if (random.one() >= strongest) return false;
    beta *= 1 / strongest;
    pdf *= strongest;
    return true;
}

/// A connection through the coat from the light's direction `wi`, found once per walk and used at every vertex.
struct Exit {
    Vec3 wi;             // outside
    LocalSample inside;  // refracted: points down, away from the coat
    Real scale;          // f / pdf |cos wi|, from inside.wi to wi
};

template <class Base>
class Evaluation {
  public:
    Evaluation(const LayeredClosure<Base>& layered, const Vec3& wi, WalkRandom& random)
        : coat_(layered.coat),
          base_(layered.base),
          random_(random),
          coat_delta_(coat_.interface.is_delta() && !(coat_.as_pbrt && !coat_.interface.facets.smooth())),
          base_delta_(!base_.has_density()) {
        exit_.wi = wi;
        const Real u_lobe = random_.one();
        exit_.inside = coat_.interface.draw(wi, u_lobe, random_.two(), TransportMode::importance, Sides::transmission);
        if (exit_.inside.pdf > 0) exit_.scale = exit_.inside.weight.r * std::abs(wi.z / exit_.inside.wi.z);
    }

    Rgb walk(const Vec3& wo) {
        const Real u_lobe = random_.one();
        const LocalSample in =
            coat_.interface.draw(wo, u_lobe, random_.two(), TransportMode::radiance, Sides::transmission);
        if (!(in.pdf > 0) || !(exit_.inside.pdf > 0)) return {};
        at_ = {coat_.thickness, in.wi};
        beta_ = in.weight;
        Real unused = 1;
        for (int depth = 0; depth < coat_.max_depth; ++depth) {
            if (!survives(depth, beta_, unused, random_)) break;
            const Advance step = advance(coat_, at_, beta_, random_);
            if (step == Advance::stuck) break;
            if (step == Advance::scattered) in_medium();
            else if (at_.z > 0 ? !below_coat() : !at_base()) break;
        }
        return result_;
    }

  private:
    void in_medium() {
        const Real g = coat_.g, phase = phase_pdf(g, at_.w, -exit_.inside.wi);
        const Real weight = coat_delta_ ? 1.0f : power_heuristic(exit_.inside.pdf, phase);
        const Real rise = coat_.thickness - at_.z;
        beta_ *= coat_.albedo;
        result_ += beta_ * (phase * weight * transmittance(rise, exit_.inside.wi) * exit_.scale);
        const PhaseSample turn = sample_phase(g, at_.w, random_.two());
        at_.w = turn.wi;
        if (at_.w.z > 0 && !coat_delta_) leave(rise, turn.pdf, false);
    }

    bool below_coat() {
        const Real u_lobe = random_.one();
        return follow(coat_.interface.draw(-at_.w, u_lobe, random_.two(), TransportMode::radiance, Sides::reflection));
    }

    bool at_base() {
        const Vec3 up = -exit_.inside.wi;
        if (!base_delta_) {
            const Real weight = coat_delta_ ? 1.0f : power_heuristic(exit_.inside.pdf, base_.pdf(-at_.w, up));
            result_ += beta_ * base_.value(-at_.w, up) * (weight * transmittance(coat_.thickness, up) * exit_.scale);
        }
        static_cast<void>(random_.one());  // would choose a lobe
        const LocalSample s = base_.draw(-at_.w, random_.two());
        if (!follow(s)) return false;
        if (!coat_delta_) leave(coat_.thickness, s.pdf, base_delta_);
        return true;
    }

    /// The other strategy: from a sampled direction straight through the rough coat to wi.
    void leave(Real rise, Real pdf, bool only_strategy) {
        const Real value = coat_.interface.value(-at_.w, exit_.wi, TransportMode::radiance);
        if (!(value > 0)) return;
        // The competing strategy refracts from wi inwards; pbrt-v4 uses the density of the way out (see layered.h).
        const Real other = coat_.as_pbrt ? coat_.interface.pdf(-at_.w, exit_.wi, Sides::transmission)
                                         : coat_.interface.pdf(exit_.wi, -at_.w, Sides::transmission);
        result_ += beta_ * (value * transmittance(rise, at_.w) * (only_strategy ? 1.0f : power_heuristic(pdf, other)));
    }

    bool follow(const LocalSample& s) {
        if (!(s.pdf > 0)) return false;
        beta_ *= s.weight;
        at_.w = s.wi;
        return true;
    }

    const CoatLayer& coat_;
    const Base& base_;
    WalkRandom& random_;
    bool coat_delta_, base_delta_;
    Exit exit_{};
    WalkPoint at_{};
    Rgb beta_, result_;
};

/// The refracted direction inside, from a direction above, through the unperturbed surface.
Vec3 refract_down(const Vec3& w, Real eta) {
    const Real cos_t = safe_sqrt(1 - (1 - w.z * w.z) / (eta * eta));
    return {-w.x / eta, -w.y / eta, -cos_t};
}

/// Density of what entered, through one reflection at a rough conductor. A tilt of the coat's facets bends a refracted
/// ray by (1 - 1/eta) of it, a tilt of the base's facets by 2: slopes' variances add up with those factors.
Real conductor_density(const CoatLayer& coat, const ConductorClosure& base, const Vec3& wo, const Vec3& wi) {
    const Real eta = coat.interface.eta;
    const Vec3 in = -refract_down(wo, eta), out = -refract_down(wi, eta);
    if (!(in.z > Real(0.01)) || !(out.z > Real(0.01))) return 0;  // beyond the critical angle, for eta < 1
    const Real bend = 0.5f * square(1 - 1 / eta);
    const auto widened = [&](Real of_base, Real of_coat) {
        return std::max(std::sqrt(square(of_base) + bend * square(of_coat)), Ggx::smooth_below);
    };
    const Ggx facets{widened(base.facets.alpha_x, coat.interface.facets.alpha_x),
                     widened(base.facets.alpha_y, coat.interface.facets.alpha_y)};
    const Real inside = facets.g1(in) * facets.d(normalize(in + out)) / (4 * in.z);
    return inside * wi.z / (eta * eta * out.z);  // d(out) / d(wi)
}

}  // namespace

template <class Base>
Real LayeredClosure<Base>::coat_value(Vec3 wo, Vec3 wi) const {
    if (!to_upper_side(wo, wi)) return 0;
    return coat.interface.value(wo, wi, TransportMode::radiance);
}

template <class Base>
Rgb LayeredClosure<Base>::base_value(Vec3 wo, Vec3 wi) const {
    if (!to_upper_side(wo, wi)) return {};
    WalkRandom random(key, wo, wi);
    Rgb sum;
    for (int i = 0; i < coat.sample_count; ++i) sum += Evaluation<Base>(*this, wi, random).walk(wo);
    return coat.sample_count > 1 ? sum / static_cast<Real>(coat.sample_count) : sum;
}

template <class Base>
BsdfEvaluation LayeredClosure<Base>::evaluate(const Vec3& wo, const Vec3& wi) const {
    const Real density = pdf(wo, wi);
    if (!(density > 0)) return {};
    if (sides == Sides::reflection) return one_lobe(lobes::coat_glossy, Rgb(coat_value(wo, wi)), density);
    const Rgb entered = base_value(wo, wi);
    if (coat.interface.is_delta() || sides == Sides::transmission) return one_lobe(Base::lobe(false), entered, density);
    return two_lobes(lobes::coat_glossy, Rgb(coat_value(wo, wi)), Base::lobe(false), entered, density);
}

template <class Base>
Real LayeredClosure<Base>::pdf(Vec3 wo, Vec3 wi) const {
    if (!to_upper_side(wo, wi)) return 0;
    if (sides == Sides::reflection) return coat.interface.pdf(wo, wi, sides);
    const Real enters = 1 - fresnel_dielectric(wo.z, coat.interface.eta);
    Real entered = LambertClosure::pdf(wo, wi);  // what a Lambert base gives through any number of reflections
    if constexpr (std::is_same_v<Base, ConductorClosure>) {
        // A smooth base under a smooth coat has a density only by the medium; else most of it is one reflection.
        if (!coat.interface.is_delta() || base.has_density())
            entered = Real(0.2) * entered + Real(0.8) * conductor_density(coat, base, wo, wi);
    }
    if (sides == Sides::transmission) return entered;
    // The weights decide how much of the biased values reaches an image. So this is the mean of pbrt-v4's estimate
    // (LayeredBxDF::PDF), which does not weigh coat and base by Fresnel's reflectance.
    if (coat.as_pbrt && !coat.interface.is_delta())
        return Real(0.9) * (coat.interface.pdf(wo, wi, Sides::reflection) + entered) + Real(0.1) * uniform_sphere_pdf();
    // Where almost nothing enters, what enters keeps a share of 2 %, so that none of its directions has a density of 0.
    const Real share = std::max(enters, Real(0.02));
    return share * entered + (1 - share) / std::max(1 - enters, Real(1e-6)) * coat.interface.pdf(wo, wi, Sides::both);
}

template <class Base>
BsdfSample LayeredClosure<Base>::sample(Vec3 wo, Real u_lobe, const Vec2& u) const {
    const bool below = wo.z < 0;
    if (below) wo = -wo;
    LocalSample s = coat.interface.draw(wo, u_lobe, u, TransportMode::radiance, sides);
    if (!(s.pdf > 0)) return {};
    Rgb beta = s.weight;
    Real pdf = s.pdf;
    bool delta = s.delta;
    const bool entered = s.transmitted;
    if (entered) {
        WalkRandom random(key, wo, {u_lobe, u.x, u.y});
        WalkPoint at{coat.thickness, s.wi};
        bool left = false;
        for (int depth = 0; depth < coat.max_depth && !left; ++depth) {
            if (!survives(depth, beta, pdf, random)) return {};
            const Advance step = advance(coat, at, beta, random);
            if (step == Advance::stuck) return {};
            if (step == Advance::scattered) {
                const PhaseSample turn = sample_phase(coat.g, at.w, random.two());
                at.w = turn.wi;
                pdf *= turn.pdf;
                beta *= coat.albedo;
                delta = false;
                continue;
            }
            const Real u_next = random.one();
            const bool at_coat = at.z > 0;
            s = at_coat ? coat.interface.draw(-at.w, u_next, random.two(), TransportMode::radiance, Sides::both)
                        : base.draw(-at.w, random.two());
            if (!(s.pdf > 0)) return {};
            beta *= s.weight;
            pdf *= s.pdf;
            delta = delta && s.delta;
            at.w = s.wi;
            left = at_coat && s.transmitted;
        }
        if (!left) return {};
    }
    LocalSample walk;
    walk.wi = below ? -s.wi : s.wi;
    walk.weight = beta;
    walk.pdf = std::clamp(pdf, Real(1e-30), Real(1e30));
    walk.delta = delta;
    BsdfSample result = one_lobe(entered ? Base::lobe(delta) : lobes::coat(delta), walk);
    result.pdf_is_proportional = !delta;
    return result;
}

template <class Base>
Rgb LayeredClosure<Base>::albedo(const Vec3& wo) const {
    const Real eta = coat.interface.eta, outside = fresnel_dielectric(std::abs(wo.z), eta);
    // Diffuse reflectance from inside, Egan and Hilgeman's fit as in Jensen et al. 2001, "A Practical Model for
    // Subsurface Light Transport".
    const Real fit = Real(0.6681) + Real(0.0636) * eta + (Real(0.7099) - Real(1.4399) / eta) / eta;
    const Real inside = eta > 1 ? std::clamp(fit, Real(0), Real(0.99)) : 0.0f;
    const Rgb below = base.albedo(wo);
    const auto one = [&](Real r) { return outside + (1 - outside) * (1 - inside) * r / (1 - inside * r); };
    return {one(below.r), one(below.g), one(below.b)};
}

template struct LayeredClosure<LambertClosure>;
template struct LayeredClosure<ConductorClosure>;

}  // namespace raylex::transport
