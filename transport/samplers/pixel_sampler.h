// Counter-based sample numbers: every number is a pure function of (seed, pixel, sample, dimension).
//
// The numbers of a Markov chain (primary_samples.h) use the same interface; an integrator then makes its samplers
// itself.
//
// Calls share no state. A path may skip numbers, threads may take any block of samples, and a run with fewer rays gets
// the same numbers at the same places (Laws 3 and 4).
//
// "sobol" is the (0, 2)-sequence of the first two Sobol' dimensions, padded: each pair of dimensions has a copy of its
// own, with the sample index shuffled and the points scrambled by hash-based Owen scrambling (B. Burley 2020,
// "Practical Hash-based Owen Scrambling", JCGT 9(4)). The hash of the scramble is N. Vegdahl's better-mixing variant of
// Laine and Karras' (2021, "Building a Better LK Hash"). Any number of samples is possible; powers of two are balanced
// best. A copy has 2^32 points; higher index bits select a new scramble.
//
// "zsobol" gives all pixels parts of one such sequence (A. Ahmed and P. Wonka 2020, "Screen-Space Blue-Noise Diffusion
// of Monte Carlo Sampling Error via Hierarchical Ordering of Pixels", ACM TOG 39(6)). Pixels along the Morton curve
// take consecutive blocks of n = 2^arrangement_bits points, so the samples of neighbouring pixels are stratified
// together. Scrambling the index permutes pixels within every square of the curve, independently for each pair of
// dimensions; it costs as much as "sobol". The n samples of a pixel stay a (0, m, 2)-net. No choice of points serves
// both n samples and more: the points that complete a net are those of the neighbours, whose errors would then be
// equal. So samples [n, 2n), [2n, 4n), ... are separate arrangements, each a net.
//
// Nested uniform scrambling is reverse - hash - reverse, and the van der Corput sequence is the index reversed, so most
// reversals cancel. The second dimension's matrix is Pascal's triangle modulo 2: five shift-and-xor steps.
#pragma once

#include <bit>
#include <cstdint>

#include "display/services/split_mix.h"
#include "transport/math/vec.h"
#include "transport/samplers/primary_samples.h"

namespace raylex::transport {

enum class SamplerKind : std::uint8_t { independent, sobol, zsobol };

namespace sampler_detail {

constexpr std::uint32_t reverse_bits(std::uint32_t x) {
    x = __builtin_bswap32(x);
    x = ((x & 0x0f0f0f0fu) << 4) | ((x >> 4) & 0x0f0f0f0fu);
    x = ((x & 0x33333333u) << 2) | ((x >> 2) & 0x33333333u);
    return ((x & 0x55555555u) << 1) | ((x >> 1) & 0x55555555u);
}

/// Flips each bit by a hash of the bits below it: Owen's tree in bit-reversed form.
constexpr std::uint32_t owen_hash(std::uint32_t x, std::uint32_t seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

/// Bit-reversed second Sobol' dimension of `index`: bit j is the parity of the index bits k with C(k, j) odd.
constexpr std::uint32_t reversed_sobol_1(std::uint32_t index) {
    index ^= (index >> 1) & 0x55555555u;
    index ^= (index >> 2) & 0x33333333u;
    index ^= (index >> 4) & 0x0f0f0f0fu;
    index ^= (index >> 8) & 0x00ff00ffu;
    return index ^ (index >> 16);
}

/// Moves bit i of the low half to bit 2i.
constexpr std::uint32_t spread_bits(std::uint32_t x) {
    x = (x | (x << 8)) & 0x00ff00ffu;
    x = (x | (x << 4)) & 0x0f0f0f0fu;
    x = (x | (x << 2)) & 0x33333333u;
    return (x | (x << 1)) & 0x55555555u;
}

constexpr Real unit_float(std::uint32_t bits) {
    return static_cast<Real>(static_cast<std::int32_t>(bits >> 8)) * 0x1p-24f;
}

/// A point of the copy of the sequence with the key `hash`.
constexpr void sobol_pair(std::uint64_t hash, std::uint32_t reversed_index, Real& x, Real& y) {
    const auto low = static_cast<std::uint32_t>(hash), high = static_cast<std::uint32_t>(hash >> 32);
    const std::uint32_t index = reverse_bits(owen_hash(reversed_index, low));
    const std::uint32_t second = reversed_sobol_1(index);
    x = unit_float(reverse_bits(owen_hash(index, high)));
    y = unit_float(reverse_bits(owen_hash(second, (low ^ (high * 0x9e3779b9u)) + 0x7f4a7c15u)));
}

}  // namespace sampler_detail

/// The random numbers of one sample of one pixel. 16 bytes, cheap to copy. Values are in [0, 1 - 2^-24].
class PixelSampler {
  public:
    PixelSampler() = default;
    /// `arrangement_bits` (zsobol): log2 of the number of samples of a pixel that are arranged together, below 32.
    PixelSampler(SamplerKind kind, std::uint64_t seed, std::int32_t x, std::int32_t y, std::uint64_t sample,
                 std::uint32_t arrangement_bits = 4) {
        using namespace sampler_detail;
        const auto ux = static_cast<std::uint32_t>(x), uy = static_cast<std::uint32_t>(y);
        if (kind == SamplerKind::zsobol) {
            arrange(seed, ux, uy, sample, arrangement_bits);
            return;
        }
        const std::uint64_t pixel_key = key_of(seed, ux, uy);
        source_ = kind == SamplerKind::sobol ? Source::sobol : Source::independent;
        const std::uint64_t copy = kind == SamplerKind::sobol ? sample >> 32 : sample;
        key_ = mix_bits(pixel_key + copy * golden_gamma);
        reversed_index_ = reverse_bits(static_cast<std::uint32_t>(sample));
    }

    /// The numbers of a chain's mutation, which must outlive every copy. Reading numbers modifies it: one thread only.
    explicit PixelSampler(PrimarySamples& chain)
        : key_(reinterpret_cast<std::uintptr_t>(&chain)), source_(Source::chain) {}

    /// The numbers of the k-th of n branches into which a path is split: independent of the path's own, and of those of
    /// another n. The branches of all samples form one sequence: n samples are spread as well as that. Not for chains.
    [[nodiscard]] PixelSampler branch(std::uint32_t k, std::uint32_t n) const {
        const std::uint64_t index = std::uint64_t{sampler_detail::reverse_bits(reversed_index_)} * n + k;
        PixelSampler numbers = *this;
        const std::uint64_t copy = source_ == Source::sobol ? index >> 32 : index;
        numbers.key_ = mix_bits(key_ + n * 0xd6e8feb86659fd93ull) + copy * golden_gamma;
        numbers.reversed_index_ = sampler_detail::reverse_bits(static_cast<std::uint32_t>(index));
        return numbers;
    }

    /// `dimension` identifies a use (lens, light choice of the third vertex, ...): equal dimensions give equal numbers.
    [[nodiscard]] Real get_1d(std::uint32_t dimension) const {
        if (source_ != Source::sobol) [[unlikely]]
            return plain_1d(dimension);
        const std::uint64_t h = hash(dimension);
        using namespace sampler_detail;
        const std::uint32_t index = reverse_bits(owen_hash(reversed_index_, static_cast<std::uint32_t>(h)));
        return unit_float(reverse_bits(owen_hash(index, static_cast<std::uint32_t>(h >> 32))));
    }
    [[nodiscard]] Vec2 get_2d(std::uint32_t dimension) const {
        if (source_ != Source::sobol) [[unlikely]]
            return plain_2d(dimension);
        Vec2 pair;
        sampler_detail::sobol_pair(hash(dimension), reversed_index_, pair.x, pair.y);
        return pair;
    }
    /// A number independent of all others for every sampler: for choices that are rare in a path.
    [[nodiscard]] Real get_random(std::uint32_t dimension) const {
        if (source_ == Source::chain) [[unlikely]]
            return chain().get(dimension, false);
        return sampler_detail::unit_float(
            static_cast<std::uint32_t>(mix_bits(hash(dimension) ^ reversed_index_) >> 32));
    }
    /// A key for another hash: distinct per (pixel, sample, dimension), but not random enough to be used directly.
    [[nodiscard]] std::uint32_t key(std::uint32_t dimension) const {
        if (source_ == Source::chain) [[unlikely]]
            return std::bit_cast<std::uint32_t>(to_float(chain().get(dimension, false)));
        return static_cast<std::uint32_t>(
            ((key_ ^ reversed_index_) + dimension * golden_gamma) * 0xbf58476d1ce4e5b9ull >> 32);
    }

  private:
    friend class SamplerBatch;
    static std::uint64_t key_of(std::uint64_t seed, std::uint32_t x, std::uint32_t y) {
        const std::uint64_t pixel = (static_cast<std::uint64_t>(y) << 32) | x;
        return mix_bits(mix_bits(seed + golden_gamma) ^ pixel);
    }
    /// The index is the place along the curve, then the sample. Squares whose places do not fit have separate keys.
    void arrange(std::uint64_t seed, std::uint32_t x, std::uint32_t y, std::uint64_t sample, std::uint32_t bits) {
        using namespace sampler_detail;
        source_ = Source::sobol;
        std::uint32_t arrangement = 0;  // for later samples: the number of doublings of the sample count
        if (sample >> bits != 0) {
            const auto width = static_cast<std::uint32_t>(std::bit_width(sample));
            arrangement = width - bits;
            bits = width - 1;
            sample ^= std::uint64_t{1} << bits;
        }
        const std::uint32_t side = bits < 32 ? (32 - bits) / 2 : 0, inside = (1u << side) - 1;
        key_ = mix_bits(key_of(seed, x >> side, y >> side) + arrangement * golden_gamma +
                        (sample >> 32) * 0xd1342543de82ef95ull);
        const std::uint64_t place = spread_bits(x & inside) | spread_bits(y & inside) << 1;
        reversed_index_ = reverse_bits(static_cast<std::uint32_t>(place << (bits & 63) | sample));
    }
    // as wide as the rest of the word: copied in whole words
    enum class Source : std::uint32_t { independent, sobol, chain };
    [[nodiscard]] PrimarySamples& chain() const {
        return *reinterpret_cast<PrimarySamples*>(static_cast<std::uintptr_t>(key_));
    }
    [[nodiscard]] Real plain_1d(std::uint32_t dimension) const {
        if (source_ == Source::chain) return chain().get(dimension, false);
        return sampler_detail::unit_float(static_cast<std::uint32_t>(hash(dimension) >> 32));
    }
    [[nodiscard]] Vec2 plain_2d(std::uint32_t dimension) const {
        if (source_ == Source::chain) {
            const Real first = chain().get(dimension, false);
            return {first, chain().get(dimension, true)};
        }
        const std::uint64_t h = hash(dimension);
        return {sampler_detail::unit_float(static_cast<std::uint32_t>(h)),
                sampler_detail::unit_float(static_cast<std::uint32_t>(h >> 32))};
    }
    static std::uint64_t dimension_key(std::uint32_t dimension) { return dimension * 0xd1342543de82ef95ull; }
    [[nodiscard]] std::uint64_t hash(std::uint32_t dimension) const {
        return mix_bits(key_ ^ dimension_key(dimension));
    }
    std::uint64_t key_ = 0;
    std::uint32_t reversed_index_ = 0;
    Source source_ = Source::independent;
};

}  // namespace raylex::transport
