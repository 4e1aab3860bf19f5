#include "transport/materials/closures/hair.h"

#include <algorithm>
#include <cmath>

#include "display/services/elementary.h"
#include "transport/materials/bsdf/lobes.h"
#include "transport/math/fresnel.h"
#include "transport/math/sampling.h"

namespace raylex::transport {

namespace {

/// I0(x) exp(-x), x >= 0: Abramowitz and Stegun 1964, 9.8.1 and 9.8.2, off by 2e-7.
Real scaled_bessel_i0(Real x) {
    const auto polynomial = [](Real t, auto... coefficients) {
        Real sum = 0, power = 1;
        ((sum += static_cast<Real>(coefficients) * power, power *= t), ...);
        return sum;
    };
    if (x < Real(3.75))
        return elementary::exp(-x) * polynomial(square(x / Real(3.75)), 1.0, 3.5156229, 3.0899424, 1.2067492, 0.2659732,
                                                0.0360768, 0.0045813);
    return polynomial(Real(3.75) / x, 0.39894228, 0.01328592, 0.00225319, -0.00157565, 0.00916281, -0.02057706,
                      0.02635537, -0.01647633, 0.00392377) /
           std::sqrt(x);
}

/// d'Eon et al. 2011, equation 7, with I0's growth and the hyperbolic sine's taken together: all exponents are at most
/// 0, at any variance. The difference that is the exponent is taken in double.
Real longitudinal(Real sine_i, Real cosine_i, Real sine_o, Real cosine_o, Real variance) {
    const double cosine_of_sum = double{cosine_i} * cosine_o - double{sine_i} * sine_o;
    const Real exponent = static_cast<Real>(std::min(cosine_of_sum - 1, 0.0) / variance);
    return scaled_bessel_i0(cosine_i * cosine_o / variance) * elementary::exp(exponent) /
           (variance * (1 - elementary::exp(-2 / variance)));
}

/// The logistic distribution of scale s, cut at -pi and pi.
Real trimmed_logistic(Real x, Real s) {
    const Real e = elementary::exp(-std::abs(x) / s), end = elementary::exp(-pi / s);
    return e / (s * square(1 + e)) * (1 + end) / (1 - end);
}

Real sample_trimmed_logistic(Real u, Real s) {
    const Real end = elementary::exp(-pi / s), lowest = end / (1 + end), inside = (1 - end) / (1 + end);
    const Real below = u * inside + lowest;
    if (!(below > 0)) return -pi;
    return std::clamp(-s * elementary::log(1 / below - 1), -pi, pi);
}

Real wrapped(Real angle) {
    return angle - 2 * pi * std::floor((angle + pi) / (2 * pi));
}

Real arcsine(Real x) {
    return elementary::asin(std::clamp(x, Real(-1), Real(1)));
}

Real cosine_of(Real sine) {
    return safe_sqrt((1 - sine) * (1 + sine));
}

constexpr std::array<LobeId, HairClosure::lobe_count> lobe_ids{lobes::hair_r, lobes::hair_tt, lobes::hair_trt,
                                                               lobes::hair_trrt};

}  // namespace

/// The quantities that depend on wo alone.
struct HairClosure::Fibre {
    Real sine, cosine, phi;               // of wo
    std::array<Rgb, lobe_count> left;     // A
    std::array<Real, lobe_count> chance;  // of choosing the lobe
    std::array<Real, 3> turn;             // around the fibre, of a ray that meets no roughness

    Fibre(const HairClosure& hair, const Vec3& wo);
};

HairClosure::Fibre::Fibre(const HairClosure& hair, const Vec3& wo)
    : sine(std::clamp(wo.x, Real(-1), Real(1))),
      cosine(std::max(cosine_of(sine), Real(1e-6))),
      phi(elementary::atan2(wo.z, wo.y)) {
    const Real h = hair.h_, eta = hair.eta_;
    // The cut across the fibre refracts as if its index were this (Marschner et al. 2003, appendix B).
    const Real effective_eta = std::sqrt(std::max(eta * eta - sine * sine, Real(1e-6))) / cosine;
    const Real sine_gamma = std::clamp(h / effective_eta, Real(-1), Real(1)), cosine_gamma = cosine_of(sine_gamma);
    const Real gamma_o = arcsine(h), gamma_t = arcsine(sine_gamma);
    const Real cosine_inside = std::max(cosine_of(std::clamp(sine / eta, Real(-1), Real(1))), Real(1e-3));
    Rgb passed;
    for (int c = 0; c < 3; ++c) passed[c] = elementary::exp(-hair.sigma_a_[c] * (2 * cosine_gamma / cosine_inside));
    const Real fresnel = fresnel_dielectric(cosine * cosine_of(h), eta);
    left[0] = Rgb(fresnel);
    left[1] = passed * square(1 - fresnel);
    left[2] = left[1] * passed * fresnel;
    for (int c = 0; c < 3; ++c) {  // the geometric series of all others; nothing enters where all is reflected
        const Real kept = 1 - passed[c] * fresnel;
        left[3][c] = kept > 0 ? left[2][c] * passed[c] * fresnel / kept : 0;
    }
    Real sum = 0;
    for (const Rgb& each : left) sum += each.average();
    for (std::size_t p = 0; p < chance.size(); ++p) chance[p] = left[p].average() / sum;
    for (std::size_t p = 0; p < turn.size(); ++p) {
        const Real passages = static_cast<Real>(p);
        turn[p] = 2 * passages * gamma_t - 2 * gamma_o + passages * pi;
    }
}

HairClosure::HairClosure(const HairParameters& p)
    : h_(std::clamp(p.h, Real(-1), Real(1))), eta_(p.eta), sigma_a_(p.sigma_a) {
    // Chiang et al., equations 7 and 8. Powers by squaring.
    const auto power = [](Real x, int n) {
        Real result = 1;
        for (; n > 0; n >>= 1, x *= x)
            if (n & 1) result *= x;
        return result;
    };
    const Real m = std::clamp(p.beta_m, Real(0.01), Real(1)), n = std::clamp(p.beta_n, Real(0.01), Real(1));
    variance_ = square(Real(0.726) * m + Real(0.812) * m * m + Real(3.7) * power(m, 20));
    scale_ = std::sqrt(pi / 8) * (Real(0.265) * n + Real(1.194) * n * n + Real(5.372) * power(n, 22));
    for (std::size_t k = 0; k < tilt_.size(); ++k) {
        const auto angle = elementary::sin_cos(p.alpha * (pi / 180) * static_cast<Real>(1 << k));
        tilt_[k] = {angle.sin, angle.cos};
    }
}

Real HairClosure::longitudinal_variance(int lobe) const {
    return lobe == 0 ? variance_ : lobe == 1 ? variance_ / 4 : variance_ * 4;
}

/// Scales turn R by -2 alpha, TT by alpha and TRT by 4 alpha.
HairClosure::Tilted HairClosure::tilted(int lobe, Real sine, Real cosine) const {
    if (lobe == 3) return {sine, cosine};
    const Tilted& by = tilt_[lobe == 0 ? 1 : lobe == 1 ? 0 : 2];
    const Real s = lobe == 0 ? -by.sine : by.sine;
    return {sine * by.cosine + cosine * s, std::abs(cosine * by.cosine - sine * s)};
}

/// The product M N of every lobe.
std::array<Real, HairClosure::lobe_count> HairClosure::densities(const Fibre& fibre, const Vec3& wi) const {
    const Real sine = std::clamp(wi.x, Real(-1), Real(1)), cosine = cosine_of(sine);
    const Real phi = elementary::atan2(wi.z, wi.y) - fibre.phi;
    std::array<Real, lobe_count> result;
    for (int p = 0; p < lobe_count; ++p) {
        const Tilted o = tilted(p, fibre.sine, fibre.cosine);
        const auto at = static_cast<std::size_t>(p);
        const Real around = p == 3 ? inv_pi / 2 : trimmed_logistic(wrapped(phi - fibre.turn[at]), scale_);
        result[at] = longitudinal(sine, cosine, o.sine, o.cosine, longitudinal_variance(p)) * around;
    }
    return result;
}

BsdfEvaluation HairClosure::evaluate(const Vec3& wo, const Vec3& wi) const {
    const Fibre fibre(*this, wo);
    const auto density = densities(fibre, wi);
    BsdfEvaluation result;
    for (std::size_t p = 0; p < density.size(); ++p) {
        const Rgb value = fibre.left[p] * density[p];
        result.value += value;
        result.pdf += fibre.chance[p] * density[p];
        result.lobes.add(lobe_ids[p], value);
    }
    return result.pdf > 0 ? result : BsdfEvaluation();
}

Real HairClosure::pdf(const Vec3& wo, const Vec3& wi) const {
    const Fibre fibre(*this, wo);
    const auto density = densities(fibre, wi);
    Real pdf = 0;
    for (std::size_t p = 0; p < density.size(); ++p) pdf += fibre.chance[p] * density[p];
    return pdf;
}

BsdfSample HairClosure::sample(const Vec3& wo, Real u_lobe, const Vec2& u) const {
    const Fibre fibre(*this, wo);
    int lobe = 0;
    Real below = 0;
    while (lobe < lobe_count - 1 && !(u_lobe < below + fibre.chance[static_cast<std::size_t>(lobe)]))
        below += fibre.chance[static_cast<std::size_t>(lobe++)];
    const auto p = static_cast<std::size_t>(lobe);
    if (!(fibre.chance[p] > 0)) return {};  // u_lobe lies in what rounding left above the last lobe
    const Real again = std::clamp((u_lobe - below) / fibre.chance[p], Real(0), one_minus_epsilon);
    // d'Eon et al. 2013, "Importance Sampling for Physically-Based Hair Fiber Models": about the tilted direction.
    const Tilted o = tilted(lobe, fibre.sine, fibre.cosine);
    const Real variance = longitudinal_variance(lobe);
    const Real inside = std::max(u.x + (1 - u.x) * elementary::exp(-2 / variance), Real(0x1p-30));
    const Real cosine = std::max(1 + variance * elementary::log(inside), Real(-1));
    const Real sine_i = std::clamp(
        -cosine * o.sine + cosine_of(cosine) * elementary::sin_cos(2 * pi * u.y).cos * o.cosine, Real(-1), Real(1));
    const Real around = lobe == 3 ? 2 * pi * again : fibre.turn[p] + sample_trimmed_logistic(again, scale_);
    const auto phi = elementary::sin_cos(fibre.phi + around);
    const Real cosine_i = cosine_of(sine_i);
    const Vec3 wi{sine_i, cosine_i * phi.cos, cosine_i * phi.sin};
    BsdfSample result = sample_of(wi, evaluate(wo, wi));
    result.transmitted = wo.z * wi.z < 0;
    return result;
}

Rgb HairClosure::albedo(const Vec3& wo) const {
    const Fibre fibre(*this, wo);
    return fibre.left[0] + fibre.left[1] + fibre.left[2] + fibre.left[3];
}

Rgb hair_absorption_of_melanin(Real eumelanin, Real pheomelanin) {
    return Rgb(Real(0.419), Real(0.697), Real(1.37)) * eumelanin +
           Rgb(Real(0.187), Real(0.4), Real(1.05)) * pheomelanin;
}

Rgb hair_absorption_of_reflectance(const Rgb& reflectance, Real beta_n) {
    const Real n = beta_n;
    const Real fit =
        Real(5.969) + n * (Real(-0.215) + n * (Real(2.532) + n * (Real(-10.73) + n * (Real(5.574) + n * Real(0.245)))));
    Rgb result;
    for (int c = 0; c < 3; ++c)  // black would absorb without end
        result[c] = square(elementary::log(std::clamp(reflectance[c], Real(1e-5), Real(1))) / fit);
    return result;
}

}  // namespace raylex::transport
