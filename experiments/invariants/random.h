// Random numbers for random scenes, the same on every machine.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace raylex::experiments {

/// SplitMix64 (Steele et al. 2014, "Fast Splittable Pseudorandom Number Generators").
class Random {
  public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    std::uint64_t bits() {
        std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ull);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
        return z ^ (z >> 31);
    }
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
