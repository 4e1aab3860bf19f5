#include "display/services/processor.h"

#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

namespace raylex::display {

#if defined(__x86_64__)

void flush_denormals() {
    constexpr unsigned flush_results = 1u << 15, flush_arguments = 1u << 6;
    _mm_setcsr(_mm_getcsr() | flush_results | flush_arguments);
}

bool has_wide_integers() {
    static const bool has = __builtin_cpu_supports("avx2");
    return has;
}

const std::vector<std::string>& instruction_sets() {
    static const std::vector<std::string> sets = {"avx512", "avx2", "avx", "sse4.2", "sse2"};
    return sets;
}

bool supports(std::string_view instruction_set) {
    __builtin_cpu_init();
    const bool sse42 = __builtin_cpu_supports("sse4.2") && __builtin_cpu_supports("popcnt");
    const bool avx = sse42 && __builtin_cpu_supports("avx");
    const bool avx2 = avx && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                      __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
    if (instruction_set == "avx512")
        return avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512cd") &&
               __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw") &&
               __builtin_cpu_supports("avx512vl");
    if (instruction_set == "avx2") return avx2;
    if (instruction_set == "avx") return avx;
    return instruction_set == "sse4.2" ? sse42 : instruction_set == "sse2";
}

#else

void flush_denormals() {
    constexpr std::uint64_t flush = 1u << 24;
    std::uint64_t control = 0;
    asm volatile("mrs %0, fpcr" : "=r"(control));
    asm volatile("msr fpcr, %0" : : "r"(control | flush));
}

bool has_wide_integers() {
    return true;
}

const std::vector<std::string>& instruction_sets() {
    static const std::vector<std::string> sets = {"neon"};
    return sets;
}

bool supports(std::string_view instruction_set) {
    return instruction_set == "neon";
}

#endif

}  // namespace raylex::display
