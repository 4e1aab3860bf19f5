// The list of closure types, and the one dispatch over it.
//
// A closure is a trivially copyable struct. Its functions take unit vectors in the shading frame that point away from
// the surface; either may lie below it.
//
//   evaluate(wo, wi)       f |cos| of every non-delta lobe and their sum, with the density of sample()
//   sample(wo, u_lobe, u)  a direction; pdf 0: none. Bsdf::sample() replaces the pdf of a sample that is neither a
//   delta
//                          nor proportional by pdf() of the rounded direction, and scales the lobes with it
//   pdf(wo, wi)            the density that evaluate() returns, to the bit
//   albedo(wo)             a rough directional albedo, for the albedo AOV
//   has_density()          false when every lobe is a delta: then evaluate() and pdf() are not called
//
// Some closures have more:
//
//   sides, side_lobes()    it chooses between reflection and transmission first, and `sides` restricts that choice
//   interface              the DielectricClosure whose index of refraction counts
//   regularize()           blurs its microfacets
//   is_black()             true: Bsdf::set() makes it a BlackClosure
//
// A closure that needs little of the frame takes world directions and the frame itself instead (WorldClosure). It reads
// no u_lobe, and the pdf of its samples is that of the rounded direction.
#pragma once

#include <cstddef>
#include <variant>

#include "transport/materials/bsdf/compensated.h"
#include "transport/materials/bsdf/diffuse_transmission.h"
#include "transport/materials/closures/custom_closure.h"
#include "transport/materials/closures/hair.h"
#include "transport/materials/closures/ideal.h"
#include "transport/materials/closures/layered.h"
#include "transport/materials/closures/measured.h"
#include "transport/materials/closures/no_surface.h"

namespace raylex::transport {

/// A new closure is one more type here. A Bsdf without a closure holds the first one.
using AnyClosure =
    std::variant<BlackClosure, PassThroughClosure, LambertClosure, PhaseClosure, ConductorClosure, GlassClosure,
                 ThinDielectricClosure, LayeredClosure<LambertClosure>, LayeredClosure<ConductorClosure>,
                 AdditiveClosure, IdealClosure, CompensatedConductor, CompensatedDielectric, DiffuseTransmissionClosure,
                 HairClosure, MeasuredClosure, CustomClosure>;

template <class Closure>
concept WorldClosure = requires(const Closure& c, const Frame& frame, const Vec3& v) {
    c.pdf(frame, v, v);
};

/// f(closure) for the closure that `any` holds, found by a binary search among the types [first, last). std::visit()
/// would call through a table of functions, into which the compiler does not inline f.
template <std::size_t first = 0, std::size_t last = std::variant_size_v<AnyClosure>, class Any, class F>
[[gnu::always_inline]] inline decltype(auto) dispatch(Any& any, const F& f) {
    constexpr std::size_t middle = (first + last) / 2;
    if constexpr (middle == first) return f(*std::get_if<first>(&any));
    else if (any.index() < middle) return dispatch<first, middle>(any, f);
    else return dispatch<middle, last>(any, f);
}

}  // namespace raylex::transport
