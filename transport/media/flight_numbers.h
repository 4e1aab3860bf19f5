// What flights through media draw: optical depths, and as many numbers as null collisions ask for.
#pragma once

#include <cmath>
#include <cstdint>

#include "display/services/elementary.h"
#include "transport/math/vec.h"
#include "transport/samplers/pixel_sampler.h"

namespace raylex::transport {

/// Two numbers of 24 bits as one of 48.
inline Real joined(const Vec2& u) {
    return u.y + u.x * Real(0x1p-24);
}

/// Optical depth that light reaches with chance 1 - u: 48 bits from either end, so that media thinner than 2^-24
/// scatter no more than they should and light gets 33 mean free paths far. Above a half the chance is taken from 1
/// exactly.
inline Real optical_depth(const Vec2& u) {
    return u.y < 0.5f ? -elementary::log1p(-joined(u)) : -elementary::log((1 - u.y) - u.x * Real(0x1p-24));
}

/// One colour's share of a choice among all, in proportion to `weights`; equal shares of a black one.
inline Rgb shares(const Rgb& weights) {
    const Real sum = weights.r + weights.g + weights.b;
    return sum > 0 && std::isfinite(sum) ? weights * (1 / sum) : Rgb(1 / Real(3));
}

/// A row of numbers from one key, without end: nobody knows beforehand how many null collisions a flight has. The
/// counter is local to one segment, so that segments stay functions of (seed, pixel, sample, dimension).
class FlightNumbers {
  public:
    /// `key`: PixelSampler::key(). `which` tells apart rows of one key.
    explicit FlightNumbers(std::uint32_t key, std::uint32_t which = 0)
        : state_(sampler_detail::mix((static_cast<std::uint64_t>(which) << 32 | key) + step)) {}

    /// Another row, of numbers of its own.
    [[nodiscard]] FlightNumbers row() {
        FlightNumbers other(0);
        other.state_ = bits();
        return other;
    }
    [[nodiscard]] Real next() { return sampler_detail::unit_float(static_cast<std::uint32_t>(bits() >> 32)); }
    [[nodiscard]] Vec2 next_2d() {
        const std::uint64_t b = bits();
        return {sampler_detail::unit_float(static_cast<std::uint32_t>(b)),
                sampler_detail::unit_float(static_cast<std::uint32_t>(b >> 32))};
    }

  private:
    static constexpr std::uint64_t step = 0x9e3779b97f4a7c15ull;
    std::uint64_t bits() { return sampler_detail::mix(state_ += step); }
    std::uint64_t state_;
};

}  // namespace raylex::transport
