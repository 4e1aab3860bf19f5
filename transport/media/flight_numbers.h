// Random numbers of free flights through media: optical depths, and as many numbers as null collisions need.
#pragma once

#include <cmath>
#include <cstdint>

#include "display/services/elementary.h"
#include "display/services/split_mix.h"
#include "transport/math/vec.h"
#include "transport/samplers/pixel_sampler.h"

namespace raylex::transport {

/// Two numbers of 24 bits as one of 48.
inline Real joined(const Vec2& u) {
    return u.y + u.x * Real(0x1p-24);
}

/// The optical depth that light reaches with probability 1 - u. 48 bits at either end, so that media thinner than 2^-24
/// do not scatter too often and light gets up to 33 mean free paths far. Above one half, 1 - u is exact.
inline Real optical_depth(const Vec2& u) {
    return u.y < 0.5f ? -elementary::log1p(-joined(u)) : -elementary::log((1 - u.y) - u.x * Real(0x1p-24));
}

/// Each colour's share in a choice among all, proportional to `weights`; equal shares if all are black.
inline Rgb shares(const Rgb& weights) {
    const Real sum = weights.r + weights.g + weights.b;
    return sum > 0 && std::isfinite(sum) ? weights * (1 / sum) : Rgb(1 / Real(3));
}

/// An unlimited sequence of numbers from one key: the number of null collisions of a flight is not known in advance.
/// The counter is local to one segment, so that segments stay functions of (seed, pixel, sample, dimension).
class FlightNumbers {
  public:
    /// `key` is PixelSampler::key(); `which` distinguishes sequences of one key.
    explicit FlightNumbers(std::uint32_t key, std::uint32_t which = 0)
        : state_(mix_bits((static_cast<std::uint64_t>(which) << 32 | key) + golden_gamma)) {}

    /// Returns an independent sequence of numbers.
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
    std::uint64_t bits() { return mix_bits(state_ += golden_gamma); }
    std::uint64_t state_;
};

}  // namespace raylex::transport
