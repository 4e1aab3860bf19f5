// The number that light transport computes in, and what is made of it. Float, unless RAYLEX_TRANSPORT_DOUBLE is defined
// (transport/docs/arithmetic.md).
//
// What comes from outside or goes there is float in both: image and mesh files, Embree, display/ and geoaovs/. It is
// taken in as it is, every float being a double, and leaves by to_float(), which does nothing in the float build.
//
// So that one source means both: a literal that float rounds is written Real(0.1), and so is one whose quotient float
// would round (1 / Real(3)); literals like 0.5f are exact and may stay.
#pragma once

#include <type_traits>

#include "display/services/rgb.h"

namespace raylex::transport {

#ifdef RAYLEX_TRANSPORT_DOUBLE
using Real = double;
#else
using Real = float;
#endif

inline constexpr bool real_is_double = std::is_same_v<Real, double>;

/// Radiance, throughput, densities by colour. What display/ takes is raylex::Rgb, always float.
using Rgb = BasicRgb<Real>;

constexpr float to_float(float v) {
    return v;
}
constexpr float to_float(double v) {
    return static_cast<float>(v);
}
constexpr const raylex::Rgb& to_float(const raylex::Rgb& c) {
    return c;
}
constexpr raylex::Rgb to_float(const RgbD& c) {
    return raylex::Rgb(c);
}

}  // namespace raylex::transport
