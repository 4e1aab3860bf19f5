// XXH64, the 64-bit hash by Yann Collet: distinguishes contents and detects damage; no protection against attacks.
// Source: "xxHash fast digest algorithm", version 0.2.0 (Cyan4973/xxHash, doc/xxhash_spec.md).
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace raylex {

[[nodiscard]] std::uint64_t hash64(std::string_view bytes, std::uint64_t seed = 0);

/// The hash as 16 hexadecimal digits.
[[nodiscard]] std::string hash_text(std::uint64_t hash);

}  // namespace raylex
