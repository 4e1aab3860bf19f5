#include "transport/samplers/sampler_batch.h"

#include "display/services/split_mix.h"

namespace raylex::transport {
namespace {

#if defined(__x86_64__)
bool has_wide_instructions() {
    static const bool has = __builtin_cpu_supports("avx2");
    return has;
}

// A plain loop, which compilers vectorise. SSE2 has no 32-bit products, so there it would not be faster.
[[gnu::target("avx2")]] void draw_sampler_pairs(const std::uint64_t* __restrict keys,
                                                const std::uint32_t* __restrict indices, std::size_t count,
                                                Real* __restrict x, Real* __restrict y) {
    for (std::size_t i = 0; i < count; ++i) sampler_detail::sobol_pair(mix_bits(keys[i]), indices[i], x[i], y[i]);
}
#else
bool has_wide_instructions() {
    return false;
}
void draw_sampler_pairs(const std::uint64_t*, const std::uint32_t*, std::size_t, Real*, Real*) {}
#endif

}  // namespace

SamplerBatch::SamplerBatch(std::size_t capacity) : keys_(capacity), indices_(capacity), x_(capacity), y_(capacity) {}

bool SamplerBatch::takes(const PixelSampler& sampler) {
    return sampler.source_ == PixelSampler::Source::sobol && has_wide_instructions();
}

void SamplerBatch::draw() {
    draw_sampler_pairs(keys_.data(), indices_.data(), count_, x_.data(), y_.data());
}

}  // namespace raylex::transport
