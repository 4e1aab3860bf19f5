// Exact sums of doubles: 128-bit fixed point, so that addition is associative and a sum has one value whatever the order.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

namespace raylex::display {

__extension__ typedef __int128 Int128;
__extension__ typedef unsigned __int128 UnsignedInt128;

/// Rounds `value` to a multiple of 2^quantum_exponent, to nearest with ties away from zero, and returns the multiple.
/// False, and `fixed` untouched, when the value is not finite or the multiple has more than 126 bits. A value with bits
/// below the quantum loses them (at most half a quantum); every other double is exact, subnormal ones included.
[[nodiscard]] inline bool to_fixed(double value, int quantum_exponent, Int128& fixed) {
    const auto bits = std::bit_cast<std::uint64_t>(value);
    const int exponent_field = static_cast<int>(bits >> 52) & 0x7ff;
    if (exponent_field == 0x7ff) return false;
    const std::uint64_t fraction = bits & 0xfffffffffffffull;
    // value = mantissa * 2^(exponent); subnormals share the exponent of field 1 and lack the leading bit.
    const std::uint64_t mantissa = exponent_field == 0 ? fraction : fraction | (std::uint64_t{1} << 52);
    const int shift = (exponent_field == 0 ? 1 : exponent_field) - 1075 - quantum_exponent;
    Int128 magnitude = 0;
    if (shift >= 0) {
        if (shift > 126 - 53) {  // might not fit: let the mantissa's own length decide
            if (mantissa == 0) {
                fixed = 0;
                return true;
            }
            if (shift + std::bit_width(mantissa) > 126) return false;
        }
        magnitude = static_cast<Int128>(mantissa) << shift;
    } else if (shift >= -53) {
        const int drop = -shift;
        magnitude = static_cast<Int128>((mantissa + (std::uint64_t{1} << (drop - 1))) >> drop);
    }  // else below half a quantum: 0
    fixed = (bits >> 63) != 0 ? -magnitude : magnitude;
    return true;
}

/// Adds unless the sum would not fit.
[[nodiscard]] inline bool add_fixed(Int128& sum, Int128 term) { return !__builtin_add_overflow(sum, term, &sum); }

/// The nearest long double to `fixed`, at a third of the time that the compiler's own conversion takes: both halves and
/// the scaling are exact, so only the addition rounds.
[[nodiscard]] inline long double as_long_double(Int128 fixed) {
    const auto high = static_cast<std::int64_t>(fixed >> 64);
    const auto low = static_cast<std::uint64_t>(fixed);
    return static_cast<long double>(high) * 0x1p64L + static_cast<long double>(low);
}

/// 2^exponent; exact, and no call as std::ldexp is.
[[nodiscard]] inline long double power_of_two(int exponent) {
    if (exponent < -1022 || exponent > 1023) return std::ldexp(1.0L, exponent);
    return static_cast<long double>(std::bit_cast<double>(static_cast<std::uint64_t>(exponent + 1023) << 52));
}

/// The nearest long double to fixed * 2^quantum_exponent: scaling by a power of two rounds nothing.
[[nodiscard]] inline long double to_long_double(Int128 fixed, int quantum_exponent) {
    return as_long_double(fixed) * power_of_two(quantum_exponent);
}

}  // namespace raylex::display
