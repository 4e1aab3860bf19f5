#include "display/services/hash64.h"

#include <array>
#include <bit>
#include <cstdio>
#include <cstring>

namespace raylex {
namespace {

constexpr std::uint64_t prime_1 = 0x9e3779b185ebca87ull, prime_2 = 0xc2b2ae3d27d4eb4full,
                        prime_3 = 0x165667b19e3779f9ull, prime_4 = 0x85ebca77c2b2ae63ull,
                        prime_5 = 0x27d4eb2f165667c5ull;

/// The specification reads little-endian words, like every machine that Embree supports.
static_assert(std::endian::native == std::endian::little);
template <class Word>
std::uint64_t read(const char* at) {
    Word word;
    std::memcpy(&word, at, sizeof word);
    return word;
}

std::uint64_t round(std::uint64_t lane, std::uint64_t input) {
    return std::rotl(lane + input * prime_2, 31) * prime_1;
}

}  // namespace

std::uint64_t hash64(std::string_view bytes, std::uint64_t seed) {
    const char* at = bytes.data();
    std::size_t left = bytes.size();
    std::uint64_t hash = seed + prime_5;
    if (left >= 32) {
        std::array<std::uint64_t, 4> lanes{seed + prime_1 + prime_2, seed + prime_2, seed, seed - prime_1};
        for (; left >= 32; left -= 32, at += 32)
            for (std::size_t i = 0; i < 4; ++i) lanes[i] = round(lanes[i], read<std::uint64_t>(at + 8 * i));
        hash = std::rotl(lanes[0], 1) + std::rotl(lanes[1], 7) + std::rotl(lanes[2], 12) + std::rotl(lanes[3], 18);
        for (const std::uint64_t lane : lanes) hash = (hash ^ round(0, lane)) * prime_1 + prime_4;
    }
    hash += bytes.size();
    for (; left >= 8; left -= 8, at += 8)
        hash = std::rotl(hash ^ round(0, read<std::uint64_t>(at)), 27) * prime_1 + prime_4;
    if (left >= 4) {
        hash = std::rotl(hash ^ (read<std::uint32_t>(at) * prime_1), 23) * prime_2 + prime_3;
        left -= 4;
        at += 4;
    }
    for (; left > 0; --left, ++at) hash = std::rotl(hash ^ (read<std::uint8_t>(at) * prime_5), 11) * prime_1;
    hash = (hash ^ (hash >> 33)) * prime_2;
    hash = (hash ^ (hash >> 29)) * prime_3;
    return hash ^ (hash >> 32);
}

std::string hash_text(std::uint64_t hash) {
    std::array<char, 17> text{};
    std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(hash));
    return text.data();
}

}  // namespace raylex
