// Random numbers of probes, the same on every machine.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include "display/services/elementary.h"
#include "display/services/split_mix.h"
#include "transport/math/sampling.h"

namespace raylex::experiments {

/// A sequence of hashes of a counter.
class CountedNumbers {
  public:
    explicit CountedNumbers(std::uint64_t seed) : at_(seed << 32) {}
    std::uint64_t bits() { return raylex::mix_bits(++at_); }
    /// Returns a number uniform in [0, 1).
    double one() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
    float one_float() { return static_cast<float>(bits() >> 40) * 0x1p-24f; }
    /// Returns a normally distributed number (Box and Muller).
    double normal() {
        return std::sqrt(-2 * elementary::log(1 - one())) * elementary::cos(2 * std::numbers::pi * one());
    }

  private:
    std::uint64_t at_;
};

}  // namespace raylex::experiments
