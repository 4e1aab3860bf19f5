// Exact sums of doubles in 128-bit fixed point: addition is associative, so a sum does not depend on the order of its
// terms.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace raylex::display {

__extension__ typedef __int128 Int128;
__extension__ typedef unsigned __int128 UnsignedInt128;

/// Rounds `value` to a multiple of 2^quantum_exponent, to nearest with ties to even, and returns the multiple. Returns
/// false and leaves `fixed` unchanged when the value is not finite or the multiple needs more than 126 bits. Bits below
/// the quantum are rounded (by at most half a quantum); every other double is exact, including subnormal ones.
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
        if (shift > 126 - 53) {  // might not fit: the length of the mantissa decides
            if (mantissa == 0) {
                fixed = 0;
                return true;
            }
            if (shift + std::bit_width(mantissa) > 126) return false;
        }
        magnitude = static_cast<Int128>(mantissa) << shift;
    } else if (shift >= -53) {
        const int drop = -shift;
        const std::uint64_t odd = drop == 53 ? 0 : mantissa >> drop & 1;
        magnitude = static_cast<Int128>((mantissa + (std::uint64_t{1} << (drop - 1)) - 1 + odd) >> drop);
    }  // otherwise at most half a quantum: 0
    fixed = (bits >> 63) != 0 ? -magnitude : magnitude;
    return true;
}

/// Adds `term` unless the sum would overflow; returns whether it added.
[[nodiscard]] inline bool add_fixed(Int128& sum, Int128 term) {
    return !__builtin_add_overflow(sum, term, &sum);
}

// x86 has 64 bits in hardware, arm64 computes 113 in software. Resolved values are rounded to 53 at the end, so one of
// some thousand differs in its last bit.
static_assert(std::numeric_limits<long double>::digits >= 64, "sums need a long double that is wider than double");

/// 2^exponent, exactly, and without the call that std::ldexp is.
[[nodiscard]] inline long double power_of_two(int exponent) {
    if (exponent < -1022 || exponent > 1023) return std::ldexp(1.0L, exponent);
    return static_cast<long double>(std::bit_cast<double>(static_cast<std::uint64_t>(exponent + 1023) << 52));
}

/// The long double closest to `fixed`, which must be below 2^126, much faster than the compiler's conversion. Both
/// halves and the scaling are exact, so only the addition rounds. The lower half is signed, because an unsigned
/// conversion has a branch that is mispredicted half of the time.
[[nodiscard]] inline long double as_long_double(Int128 fixed) {
    const auto low = static_cast<std::int64_t>(fixed);
    const auto high = static_cast<std::int64_t>(fixed >> 64) + (low < 0 ? 1 : 0);
    return static_cast<long double>(high) * 0x1p64L + static_cast<long double>(low);
}

/// The sum of at most 2^12 arrays of `count` doubles, each rounded as by to_fixed(): the same total much faster,
/// because two numbers are added at once. Adding large constants splits a number into three parts: bits below the last
/// bit of the constant are rounded off. The bit pattern then contains the part as an integer multiple of that last bit.
template <std::size_t count>
class FixedSum {
  public:
    explicit FixedSum(int quantum_exponent) : scale_(static_cast<double>(power_of_two(-quantum_exponent))) {}

    /// Adds an array. Returns false and adds nothing if its magnitudes sum to 2^110 quanta or more, or if it is not
    /// finite; the caller then uses to_fixed().
    [[gnu::always_inline]] bool add(const std::array<double, count>& values) {
        Pair scaled[pairs], size{};
        for (std::size_t i = 0; i < pairs; ++i) {
            scaled[i] = Pair{values[2 * i], 2 * i + 1 < count ? values[2 * i + 1] : 0.0} * scale_;
            size += reinterpret_cast<Pair>(reinterpret_cast<Bits>(scaled[i]) & (~Bits{} >> 1));  // without the sign
        }
        if (!(size[0] + size[1] < 0x1p110)) [[unlikely]]
            return false;  // NaN too
        ++added_;
        for (std::size_t i = 0; i < pairs; ++i) {
            const Pair high = scaled[i] + high_unit;
            const Pair below_high = scaled[i] - (high - high_unit);
            const Pair middle = below_high + middle_unit;
            const Pair low = below_high - (middle - middle_unit) + low_unit;
            high_[i] += reinterpret_cast<Bits>(high);
            middle_[i] += reinterpret_cast<Bits>(middle);
            low_[i] += reinterpret_cast<Bits>(low);
        }
        return true;
    }
    [[nodiscard]] std::array<Int128, count> total() const {
        std::array<Int128, count> sum;
        for (std::size_t c = 0; c < count; ++c) {
            const auto units = [&](const Bits* of, double unit) {
                return static_cast<Int128>(
                    static_cast<std::int64_t>(of[c / 2][c % 2] - added_ * std::bit_cast<std::uint64_t>(unit)));
            };
            sum[c] = (units(high_, high_unit) << 60) + (units(middle_, middle_unit) << 9) + units(low_, low_unit);
        }
        return sum;
    }

  private:
    using Pair [[gnu::vector_size(16)]] = double;
    using Bits [[gnu::vector_size(16)]] = std::uint64_t;
    static constexpr std::size_t pairs = (count + 1) / 2;
    // The last bits of the units are 2^60, 2^9 and 1, so each part is at most 2^50 of them.
    static constexpr double high_unit = 0x1.8p112, middle_unit = 0x1.8p61, low_unit = 0x1.8p52;

    Bits high_[pairs] = {}, middle_[pairs] = {}, low_[pairs] = {};
    std::uint64_t added_ = 0;
    double scale_;
};

/// The long double closest to fixed * 2^quantum_exponent; scaling by a power of two does not round.
[[nodiscard]] inline long double to_long_double(Int128 fixed, int quantum_exponent) {
    return as_long_double(fixed) * power_of_two(quantum_exponent);
}

}  // namespace raylex::display
