// What closures hand to one another in the shading frame, where z is the cosine to the normal.
#pragma once

#include <cstdint>

#include "transport/math/real.h"
#include "transport/math/vec.h"

namespace raylex::transport {

/// A direction drawn by one closure; pdf 0 marks failure.
struct LocalSample {
    Vec3 wi;
    Rgb weight;    ///< f |cos| / pdf
    Real pdf = 0;  ///< per steradian; a probability when `delta`
    Real eta = 1;  ///< transmitted over incident index; 1 unless transmitted through an interface
    bool delta = false;
    bool transmitted = false;
};

/// What is carried along the path: radiance is scaled by 1/eta^2 on crossing an interface, importance is not
/// (Veach 1997, section 5.2).
enum class TransportMode : std::uint8_t { radiance, importance };

/// Which side a sample may go to: the coat of a layered surface is asked for one of them at a time.
enum class Sides : std::uint8_t { reflection = 1, transmission = 2, both = 3 };
constexpr bool allows(Sides sides, Sides side) {
    return (static_cast<unsigned>(sides) & static_cast<unsigned>(side)) != 0;
}

}  // namespace raylex::transport
