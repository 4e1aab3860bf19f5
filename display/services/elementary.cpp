#include "display/services/elementary.h"

namespace raylex::elementary {
namespace detail {
namespace {

__extension__ typedef unsigned __int128 Wide;

/// An unevaluated sum; low is at most half a unit in the last place of high.
struct Pair {
    double high, low;
};
Pair sum_of(double a, double b) {  // Knuth
    const double s = a + b, t = s - a;
    return {s, (a - (s - t)) + (b - t)};
}
Pair halves_of(double a) {  // Veltkamp: 26 and 26 bits
    const double t = a * 0x1.0000002p27, high = t - (t - a);
    return {high, a - high};
}
Pair product_of(double a, double b) {  // Dekker
    const Pair p = halves_of(a), q = halves_of(b);
    const double s = a * b;
    return {s, ((p.high * q.high - s) + p.high * q.low + p.low * q.high) + p.low * q.low};
}
Pair product_of(const Pair& a, const Pair& b) {
    const Pair p = product_of(a.high, b.high);
    return sum_of(p.high, p.low + (a.high * b.low + a.low * b.high));
}

/// The bits of 2/pi after the point, preceded by 64 zeros.
constexpr std::uint64_t two_over_pi[] = {0,
                                         0xa2f9836e4e441529,
                                         0xfc2757d1f534ddc0,
                                         0xdb6295993c439041,
                                         0xfe5163abdebbc561,
                                         0xb7246e3a424dd2e0,
                                         0x06492eea09d1921c,
                                         0xfe1deb1cb129a73e,
                                         0xe88235f52ebb4484,
                                         0xe99c7026b45f7e41,
                                         0x3991d639835339f4,
                                         0x9c845f8bbdf9283b,
                                         0x1ff897ffde05980f,
                                         0xef2f118b5a0a6d1f,
                                         0x6d367ecf27cb09b7,
                                         0x4f463f669e5fea2d,
                                         0x7527bac7ebe5f17b,
                                         0x3d0739f78a5292ea,
                                         0x6bfb5fb11f8d5d08,
                                         0x56033046fc7b6bab,
                                         0xf0cfbc209af4361d};

}  // namespace

Reduced reduce_large(double argument) {
    const double x = std::abs(argument);
    if (!(x < infinity)) return {0, nan, nan};
    // x is m 2^e. Bits of 2/pi whose product with m 2^e is a multiple of 4 are not needed. 192 bits from there on give
    // an error of 2^-137, and no double is closer to a multiple of pi/2 than 2^-62 (Muller, section 11.3).
    const std::uint64_t m = (bits_of(x) & 0xfffffffffffff) | std::uint64_t(1) << 52;
    const int e = static_cast<int>(bits_of(x) >> 52) - 1075, first = e - 2 + 64;
    std::uint64_t factor[3];  // highest first
    for (int i = 0; i < 3; ++i) {
        const std::uint64_t* word = two_over_pi + first / 64 + i;
        const int shift = first % 64;
        factor[i] = shift == 0 ? word[0] : word[0] << shift | word[1] >> (64 - shift);
    }
    const Wide low = Wide(m) * factor[2], middle = Wide(m) * factor[1] + static_cast<std::uint64_t>(low >> 64);
    std::uint64_t words[3] = {m * factor[0] + static_cast<std::uint64_t>(middle >> 64),
                              static_cast<std::uint64_t>(middle), static_cast<std::uint64_t>(low)};
    // The product in quarters of a turn, with two bits before the point. Rounding to nearest gives the remainder a
    // sign.
    const std::uint64_t quadrant = ((words[0] >> 61) + 1) >> 1;
    words[0] = (words[0] << 2 | words[1] >> 62), words[1] = words[1] << 2 | words[2] >> 62, words[2] <<= 2;
    const bool above = words[0] >> 63 != 0;
    if (above) {  // 1 - fraction
        words[2] = 0 - words[2];
        words[1] = ~words[1] + (words[2] == 0);
        words[0] = ~words[0] + (words[2] == 0 && words[1] == 0);
    }
    Pair fraction{0, 0};
    for (int half = 0; half < 6; ++half) {
        const double part =
            static_cast<double>(static_cast<std::uint32_t>(words[half / 2] >> (half % 2 == 0 ? 32 : 0)));
        const Pair sum = sum_of(fraction.high, std::ldexp(part, -32 * (half + 1)));
        fraction = sum_of(sum.high, sum.low + fraction.low);
    }
    const Pair r = product_of(fraction, {half_pi, half_pi_low});
    const bool negative = above != (argument < 0);
    const std::uint64_t turned = argument < 0 ? 0 - quadrant : quadrant;
    return {turned, negative ? -r.high : r.high, negative ? -r.low : r.low};
}

SinCos<float> sin_cos_far(float x) {
    const SinCos<double> a = sin_cos_of(reduce_large(x));
    return {static_cast<float>(a.sin), static_cast<float>(a.cos)};
}

namespace {

/// log(x) of a normal number above 0, to about 2^-64: log_of_parts() plus the rounding errors of its largest terms.
Pair log_pair(double x, double exponent) {
    const Mantissa a = split_mantissa(x);
    const double f = a.m - 1, k = a.k + exponent;
    const Pair divisor = sum_of(a.m, 1);
    const double s_high = f / divisor.high;
    const Pair back = product_of(s_high, divisor.high);
    const Pair s = sum_of(s_high, (((f - back.high) - back.low) - s_high * divisor.low) / divisor.high);
    const Pair z = product_of(s, s);
    // (2 atanh(s) - 2 s) / s^3 = 2/3 + z times this: 2^-65.3 of the logarithm
    const double tail =
        polynomial(z.high, 0x1.9999999999b2cp-2, 0x1.24924924583c2p-2, 0x1.c71c722cf02e9p-3, 0x1.745cea05367dap-3,
                   0x1.3b1ee6e270e32p-3, 0x1.0f8050388dad8p-3, 0x1.0e3f78b2e7ab7p-3);
    const Pair factor = sum_of(0x1.5555555555555p-1, 0x1.5555555555555p-55 + z.high * tail);
    const Pair rest = product_of(product_of(s, z), factor);
    const Pair whole = sum_of(k * 0x1.62e42fefa38p-1, 2 * s.high);
    const Pair sum = sum_of(whole.high, rest.high);
    return sum_of(sum.high, sum.low + (whole.low + (k * 0x1.ef35793c7673p-45 + (2 * s.low + rest.low))));
}

/// The kind of y as an integer: 0 is none, 1 even, 2 odd.
int integer_kind(double y) {
    if (!(std::abs(y) < detail::infinity) || y != std::floor(y)) return std::abs(y) == infinity ? 1 : 0;
    return std::fmod(y, 2) == 0 ? 1 : 2;
}

/// The sign of a power and its special cases, as C defines them; `power` computes |x|^y for |x| > 0.
template <class Power>
double signed_power(double x, double y, Power power) {
    if (y == 0 || x == 1) return 1;
    if (x != x || y != y) return nan;
    const bool negative = bits_of(x) >> 63 != 0;
    const int kind = negative ? integer_kind(y) : 1;
    const double a = std::abs(x);
    double result = 1;
    if (a == 0 || a == infinity) result = (a == 0) == (y > 0) ? 0 : infinity;
    else if (std::abs(y) == infinity) result = a == 1 ? 1 : (a < 1) == (y > 0) ? 0 : infinity;
    else result = kind == 0 ? nan : power(a);
    return kind == 2 ? -result : result;
}

}  // namespace
}  // namespace detail

double pow(double x, double y) {
    return detail::signed_power(x, y, [y](double a) {
        const bool denormal = a < std::numeric_limits<double>::min();
        const detail::Pair l = detail::log_pair(denormal ? a * 0x1p54 : a, denormal ? -54 : 0);
        // Beyond these limits any power overflows or underflows; within them the halves of the product stay in range.
        const double limited = std::abs(y) > 0x1p65 ? std::copysign(0x1p65, y) : y;
        const detail::Pair p = detail::product_of(l.high, limited);
        const bool beyond = std::abs(p.high) > 800;  // then its low part can be anything
        return detail::exp_of_sum(p.high, beyond ? 0 : p.low + l.low * limited);
    });
}

float pow(float x, float y) {
    const double exponent = y;
    return static_cast<float>(detail::signed_power(
        x, exponent, [exponent](double a) { return detail::exp_short(exponent * detail::log_short(a)); }));
}

double cbrt(double x) {
    const double a = std::abs(x);
    if (!(a > 0 && a < detail::infinity)) return x;
    int exponent = 0;
    double m = std::frexp(a, &exponent);  // [1/2, 1)
    const int left = ((exponent % 3) + 3) % 3;
    m = std::ldexp(m, left);  // [1/2, 4)
    double t = 0.75 + 0.25 * m;
    for (int i = 0; i < 4; ++i) {  // Halley: cubic convergence from 15 %
        const double cube = t * t * t;
        t += t * ((m - cube) / (2 * cube + m));
    }
    return std::copysign(std::ldexp(t, (exponent - left) / 3), x);
}

}  // namespace raylex::elementary
