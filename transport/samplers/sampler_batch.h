// Pairs of numbers for many samples at once: the same bits as PixelSampler::get_2d, by instructions that process eight
// of them (AVX2, if the machine supports it). A render needs about five pairs per camera sample, which take a tenth of
// its time one by one.
#pragma once

#include <cstdint>
#include <vector>

#include "transport/samplers/pixel_sampler.h"

namespace raylex::transport {

class SamplerBatch {
  public:
    explicit SamplerBatch(std::size_t capacity);

    /// Whether the numbers of samplers of this kind can be drawn in batches. Numbers of chains change when they are
    /// read, and independent ones cost next to nothing.
    [[nodiscard]] static bool takes(const PixelSampler& sampler);

    void clear() { count_ = 0; }
    void add(const PixelSampler& sampler, std::uint32_t dimension) {
        keys_[count_] = sampler.key_ ^ PixelSampler::dimension_key(dimension);
        indices_[count_++] = sampler.reversed_index_;
    }
    void draw();
    /// The numbers of the i-th sampler added before draw().
    [[nodiscard]] Vec2 operator[](std::size_t i) const { return {x_[i], y_[i]}; }

  private:
    std::size_t count_ = 0;
    std::vector<std::uint64_t> keys_;
    std::vector<std::uint32_t> indices_;
    std::vector<Real> x_, y_;
};

}  // namespace raylex::transport
