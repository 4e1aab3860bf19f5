// SplitMix64: the 64-bit finaliser and the counter's step. G. Steele, D. Lea, C. Flood, "Fast Splittable Pseudorandom
// Number Generators", OOPSLA 2014; the finaliser is Stafford's variant 13 of MurmurHash3's.
#pragma once

#include <cstdint>

namespace raylex {

/// The step of the counter: 2^64 over the golden ratio, rounded to odd.
inline constexpr std::uint64_t golden_gamma = 0x9e3779b97f4a7c15ull;

/// Converts a counter to random bits: a bijection that mixes every bit, and maps 0 to 0.
constexpr std::uint64_t mix_bits(std::uint64_t v) {
    v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9ull;
    v = (v ^ (v >> 27)) * 0x94d049bb133111ebull;
    return v ^ (v >> 31);
}

}  // namespace raylex
