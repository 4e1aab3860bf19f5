// What closures are made of: samples in the shading frame, where z is the cosine to the normal, and results with lobes.
#pragma once

#include <array>
#include <cstdint>

#include "transport/materials/bsdf/bsdf.h"

namespace raylex::transport {

/// A direction drawn by one part of a closure; pdf 0 marks failure.
struct LocalSample {
    Vec3 wi;
    Rgb weight;    ///< f |cos| / pdf
    Real pdf = 0;  ///< per steradian; a probability when `delta`
    Real eta = 1;  ///< transmitted over incident index; 1 unless transmitted through an interface
    bool delta = false;
    bool transmitted = false;
};

/// The result of evaluate() where one lobe alone scatters from wo to wi.
inline BsdfEvaluation one_lobe(LobeId lobe, const Rgb& value, Real pdf) {
    BsdfEvaluation result;
    if (!(pdf > 0)) return result;
    result.value = value;
    result.pdf = pdf;
    result.lobes.add(lobe, value);
    return result;
}

/// The result of sample() where one lobe alone gives the direction.
inline BsdfSample one_lobe(LobeId lobe, const LocalSample& s) {
    BsdfSample result;
    if (!(s.pdf > 0)) return result;
    result.wi = s.wi;
    result.weight = s.weight;
    result.pdf = s.pdf;
    result.eta = s.eta;
    result.delta = s.delta;
    result.transmitted = s.transmitted;
    result.lobes.add(lobe, s.weight * s.pdf);
    return result;
}

/// The result of evaluate() where two lobes overlap: their sum, in this order (Law 5).
inline BsdfEvaluation two_lobes(LobeId first, const Rgb& a, LobeId second, const Rgb& b, Real pdf) {
    BsdfEvaluation result;
    if (!(pdf > 0)) return result;
    result.value = a + b;
    result.pdf = pdf;
    result.lobes.add(first, a);
    result.lobes.add(second, b);
    return result;
}

/// The result of sample() for the direction wi, where evaluate() gave `all` for it.
inline BsdfSample sample_of(const Vec3& wi, const BsdfEvaluation& all) {
    BsdfSample result;
    if (!(all.pdf > 0)) return result;
    result.wi = wi;
    result.weight = all.value / all.pdf;
    result.pdf = all.pdf;
    result.lobes = all.lobes;
    return result;
}

/// What is carried along the path: radiance is scaled by 1/eta^2 on crossing an interface, importance is not
/// (Veach 1997, section 5.2).
enum class TransportMode : std::uint8_t { radiance, importance };

/// The sides of an interface to which a sample may go.
enum class Sides : std::uint8_t { reflection, transmission, both };

/// The chance of reflecting: `share`, or certainty where only one side is allowed.
constexpr Real reflection_chance(Real share, Sides sides) {
    if (sides == Sides::both) return share;
    return sides == Sides::reflection ? 1.0f : 0.0f;
}

/// The lobes of a closure that chooses a side of its outer interface first.
struct SideLobes {
    LobeId reflected;              ///< of light that does not enter
    std::array<LobeId, 2> passed;  ///< of light that enters, whether it leaves again or not
};

}  // namespace raylex::transport
