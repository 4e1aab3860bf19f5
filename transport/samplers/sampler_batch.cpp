#include "transport/samplers/sampler_batch.h"

#include "display/services/processor.h"
#include "display/services/split_mix.h"

namespace raylex::transport {
namespace {

// A plain loop, which compilers vectorise.
RAYLEX_WIDE_INTEGERS void draw_sampler_pairs(const std::uint64_t* __restrict keys,
                                             const std::uint32_t* __restrict indices, std::size_t count,
                                             Real* __restrict x, Real* __restrict y) {
    for (std::size_t i = 0; i < count; ++i) sampler_detail::sobol_pair(mix_bits(keys[i]), indices[i], x[i], y[i]);
}

}  // namespace

SamplerBatch::SamplerBatch(std::size_t capacity) : keys_(capacity), indices_(capacity), x_(capacity), y_(capacity) {}

bool SamplerBatch::takes(const PixelSampler& sampler) {
    return sampler.source_ == PixelSampler::Source::sobol && display::has_wide_integers();
}

void SamplerBatch::draw() {
    draw_sampler_pairs(keys_.data(), indices_.data(), count_, x_.data(), y_.data());
}

}  // namespace raylex::transport
