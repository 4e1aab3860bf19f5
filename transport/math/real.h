// The number type of light transport and the types built from it. Float, unless RAYLEX_TRANSPORT_DOUBLE is defined
// (transport/docs/arithmetic.md).
//
// Inputs and outputs are float in both cases: image and mesh files, Embree, display/ and geoaovs/. Inputs convert
// implicitly, since every float is a double; outputs are converted by to_float(), which does nothing in the float
// build.
//
// One source serves both: literals that float rounds are written Real(0.1), and so are those whose quotient float would
// round (1 / Real(3)). Exact literals like 0.5f need no conversion.
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

/// Radiance, throughput and densities by colour. display/ uses raylex::Rgb, always float.
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
