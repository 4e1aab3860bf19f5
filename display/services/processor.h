// What depends on the kind of processor: denormals, instruction sets, and the type of its programs. All other code is
// C++ with vectors of g++ and clang, which any 64-bit little-endian processor runs.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#if defined(__x86_64__)
/// Before a function: it may use AVX2, so it is called only if has_wide_integers().
#define RAYLEX_WIDE_INTEGERS [[gnu::target("avx2")]]
#elif defined(__aarch64__)
#define RAYLEX_WIDE_INTEGERS
#else
#error "raylex supports x86-64 and arm64; another processor needs its part in display/services/processor.*"
#endif

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_THREAD__)
/// Before a function: wider vectors where the processor has them. Both versions have the same bits, because neither
/// fuses operations.
#define RAYLEX_WIDE [[gnu::target_clones("avx2", "default")]]
#else
#define RAYLEX_WIDE
#endif

namespace raylex::display {

#if defined(__x86_64__)
inline constexpr std::uint16_t elf_machine = 62;  // EM_X86_64
inline constexpr std::string_view instruction_set_names = "sse2, sse4.2, avx, avx2 or avx512";
#else
inline constexpr std::uint16_t elf_machine = 183;  // EM_AARCH64
inline constexpr std::string_view instruction_set_names = "neon";
#endif

/// Makes the calling thread flush denormals to zero, as arguments and as results of float and double. x86 flushes what
/// is denormal after rounding, arm64 what is denormal before it.
void flush_denormals();

/// Whether vectors of 32-bit integers can be multiplied. SSE2, which all x86 processors have, cannot do it.
bool has_wide_integers();

/// The instruction sets of this kind of processor by Embree's names, widest first.
const std::vector<std::string>& instruction_sets();

/// Whether this processor has all features that Embree requires for an instruction set.
bool supports(std::string_view instruction_set);

}  // namespace raylex::display
