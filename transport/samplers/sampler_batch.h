// Pairs of numbers of many samples at once: what PixelSampler::get_2d gives for each, bit for bit, by instructions that
// work on eight of them (AVX2, where the machine has it). A render asks for some five pairs a camera sample, a tenth of
// its time one by one.
#pragma once

#include <cstdint>
#include <vector>

#include "transport/samplers/pixel_sampler.h"

namespace raylex::transport {

class SamplerBatch {
  public:
    explicit SamplerBatch(std::size_t capacity);

    /// Whether the numbers of samplers like this one can be drawn so. Those of chains change by being asked for, and
    /// independent ones cost next to nothing.
    [[nodiscard]] static bool takes(const PixelSampler& sampler);

    void clear() { count_ = 0; }
    void add(const PixelSampler& sampler, std::uint32_t dimension) {
        keys_[count_] = sampler.key_ ^ PixelSampler::dimension_key(dimension);
        indices_[count_++] = sampler.reversed_index_;
    }
    void draw();
    /// Of the i-th that was added before draw().
    [[nodiscard]] Vec2 operator[](std::size_t i) const { return {x_[i], y_[i]}; }

  private:
    std::size_t count_ = 0;
    std::vector<std::uint64_t> keys_;
    std::vector<std::uint32_t> indices_;
    std::vector<Real> x_, y_;
};

}  // namespace raylex::transport
