// Random small scenes of extreme sizes, places, materials, lights, media and cameras: what the soak renders.
#pragma once

#include <cstdint>
#include <string>

#include "transport/render/render.h"

namespace soak_test {

/// Numbers by SplitMix64 (Steele et al. 2014, "Fast Splittable Pseudorandom Number Generators"): the same everywhere.
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

  private:
    std::uint64_t state_;
};

/// Scene number `index` as a pbrt file.
std::string random_scene(std::uint64_t index);
/// How it is rendered: channels that partition the beauty among them, which are the first `partition` of its channels.
raylex::transport::RenderSettings random_settings(std::uint64_t index, std::size_t& partition);

}  // namespace soak_test
