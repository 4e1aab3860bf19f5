// Random numbers for random scenes, the same on every machine.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "display/services/split_mix.h"

namespace raylex::experiments {

/// SplitMix64.
class Random {
  public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    std::uint64_t bits() { return mix_bits(state_ += golden_gamma); }
    double unit() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
    double between(double a, double b) { return a + (b - a) * unit(); }
    std::size_t below(std::size_t n) { return static_cast<std::size_t>(bits() % n); }
    bool chance(double p) { return unit() < p; }
    template <typename Item, std::size_t n>
    const Item& one_of(const std::array<Item, n>& items) {
        return items[below(n)];
    }

  private:
    std::uint64_t state_;
};

}  // namespace raylex::experiments
