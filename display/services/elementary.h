// Elementary functions whose bits do not depend on the processor.
//
// The C library selects its sin, exp, pow ... by the features of the processor. Versions with fused multiply-add differ
// from the others in the last bit, and so do versions of the library. Here every operation is one of IEEE 754 in the
// written order (the project compiles without contraction), so the bits are the same on every machine, also if a
// compiler vectorises the code. Everything that can affect an image uses these functions; a test searches the sources
// for others (tests/services/elementary_lint_test.cpp). sqrt, fma, floor, rint, fmod, remainder, frexp and ldexp are
// exact in any library and can be used.
//
// Largest errors in units in the last place, measured (tests/services/elementary_test.cpp):
//
//     float    all below 0.51: they are computed in double and rounded once
//     double   sin, cos 0.8; tan 2.1; exp, exp2 1.0; expm1 1.5; log 0.9; log2, log1p 2.1; atan, atan2 2.2; asin 1.7;
//              acos, pow 1.1; hypot 1.3; cbrt 1.0
//
// Arguments can be anything: results for zeros, infinities, NaN, denormals and arguments outside the domain are those
// of C (annex F), except for the sign of a NaN. sin and cos reduce by pi/2 in four parts below 2^20, and by as many
// bits of 2/pi as necessary above (Payne and Hanek 1983, "Radian Reduction for Trigonometric Functions").
//
// Methods: Cody and Waite 1980, "Software Manual for the Elementary Functions" (reductions by constants in parts);
// Muller 2016, "Elementary Functions", chapters 3 and 11; Ng's arrangement of log and of the sine of a sum in FDLIBM.
// The polynomials are minimax for the relative error of the function, by the Remez exchange in 60 digits on the reduced
// interval widened by 1e-4, with coefficients rounded to double; the power of two beside each is its error.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace raylex::elementary {

template <class Real>
struct SinCos {
    Real sin, cos;
};

namespace detail {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double to_integer = 0x1.8p52;  ///< adding and subtracting it rounds to the nearest integer, for numbers below
                                         ///< 2^51
constexpr double largest_reduced = 0x1p20;

constexpr double polynomial(double, double c) {
    return c;
}
template <class... Further>
constexpr double polynomial(double x, double c, Further... further) {
    return c + x * polynomial(x, further...);
}
constexpr std::uint64_t bits_of(double x) {
    return std::bit_cast<std::uint64_t>(x);
}
constexpr double with_sign_bit(double x, std::uint64_t negative) {
    return std::bit_cast<double>(bits_of(x) ^ negative << 63);
}
/// 2^k for the argument k + to_integer, -1022 <= k <= 1023.
constexpr double power_of_two(double shifted) {
    return std::bit_cast<double>((bits_of(shifted) + 1023) << 52);
}

/// x - quadrant pi/2 as the sum of two numbers, in [-pi/4, pi/4] up to rounding.
struct Reduced {
    std::uint64_t quadrant;  ///< only its two lowest bits matter
    double high, low;
};
Reduced reduce_large(double x);  // any |x|

/// The reduction for |x| <= largest_reduced. pi/2 is in parts of 33 bits, so that products are exact. The two largest
/// differences keep their rounding errors, for arguments next to a multiple of pi/2.
inline Reduced reduce(double x) {
    const double shifted = x * 0x1.45f306dc9c883p-1 + to_integer, k = shifted - to_integer;
    const double a = x - k * 0x1.921fb544p+0, b = k * 0x1.0b4611a6p-34, c = a - b, c_low = (a - c) - b;
    const double d = k * 0x1.3198a2ep-69, e = c - d, e_low = (c - e) - d;
    const double low = e_low + (c_low - k * 0x1.b839a252049c1p-104), high = e + low;
    return {bits_of(shifted), high, (e - high) + low};
}

inline SinCos<double> place(std::uint64_t quadrant, double sine, double cosine) {
    const bool swapped = (quadrant & 1) != 0;
    return {with_sign_bit(swapped ? cosine : sine, quadrant >> 1 & 1),
            with_sign_bit(swapped ? sine : cosine, (quadrant + 1) >> 1 & 1)};
}

/// sin and cos on [-pi/4, pi/4], with errors 2^-68.8 and 2^-64.2.
inline SinCos<double> sin_cos_of(const Reduced& r) {
    const double x = r.high, z = x * x;
    const double s =
        polynomial(z, -0x1.5555555555555p-3, 0x1.111111111110bp-7, -0x1.a01a01a018aedp-13, 0x1.71de3a533a19ep-19,
                   -0x1.ae645298fc5e8p-26, 0x1.61209313ed452p-33, -0x1.aaa56c274e112p-41);
    const double c = polynomial(z, 0x1.555555555554cp-5, -0x1.6c16c16c15183p-10, 0x1.a01a019cb228ep-16,
                                -0x1.27e4f80a335dbp-22, 0x1.1ee9ec113a34ep-29, -0x1.8faeaf0efffc2p-37);
    const double half = 0.5 * z, most = 1 - half;
    return place(r.quadrant, x + (x * z * s + r.low * most), most + (((1 - most) - half) + (z * z * c - x * r.low)));
}

/// sin and cos for float, |x| <= largest_reduced, with errors 2^-37.6 and 2^-43.2. It has no branches, so that
/// compilers vectorise loops of it.
inline SinCos<float> sin_cos_near(float argument) {
    const double x = argument, shifted = x * 0x1.45f306dc9c883p-1 + to_integer, k = shifted - to_integer;
    const double r = (x - k * 0x1.921fb544p+0) - k * 0x1.0b4611a626331p-34, z = r * r;
    const double s =
        polynomial(z, -0x1.5555554cba219p-3, 0x1.11110896134acp-7, -0x1.a00f9d4e5733ep-13, 0x1.6cd83d496600cp-19);
    const double c =
        polynomial(z, 0x1.5555554f4ddc1p-5, -0x1.6c16b8984c91cp-10, 0x1.a0111fcbcfc7ap-16, -0x1.242ac1cb1b54cp-22);
    const SinCos<double> placed = place(bits_of(shifted), r * (1 + z * s), (1 - 0.5 * z) + z * z * c);
    return {static_cast<float>(placed.sin), static_cast<float>(placed.cos)};
}
SinCos<float> sin_cos_far(float x);

/// 2^(log2(e) x) = 2^k e^r, |r| <= ln(2) / 2, ln(2) in two parts.
struct PowerOfTwo {
    double shifted;  ///< k + to_integer
    double k, r, r_low;
};
inline PowerOfTwo split_exponent(double x) {
    const double shifted = x * 0x1.71547652b82fep+0 + to_integer, k = shifted - to_integer;
    const double high = x - k * 0x1.62e42fefa38p-1, low = k * 0x1.ef35793c7673p-45, r = high - low;
    return {shifted, k, r, (high - r) - low};
}
/// (e^r - 1 - r) / r^2; 2^-61.7 of e^r - 1.
inline double exp_tail(double r) {
    return polynomial(r, 0.5, 0x1.5555555555559p-3, 0x1.555555555555ap-5, 0x1.111111110f6aep-7, 0x1.6c16c16c1442bp-10,
                      0x1.a01a01afe533ap-13, 0x1.a01a01b0bfca2p-16, 0x1.71ddf8537bf2cp-19, 0x1.27e4c592141cap-22,
                      0x1.af5ebf4685daep-26, 0x1.1f9575ff46854p-29);
}
/// (e^r - 1 - r) / r^2 for float; 2^-32.0 of e^r - 1.
inline double exp_tail_short(double r) {
    return polynomial(r, 0x1.00000027d2772p-1, 0x1.55555588e9487p-3, 0x1.5554add691f46p-5, 0x1.11108ffb73f2ap-7,
                      0x1.6d748b4a29adfp-10, 0x1.a1a0b89fae415p-13);
}
/// y 2^k, rounded once, for -2044 <= k <= 2046.
inline double scaled(double y, double k) {
    const double half = k * 0.5 + to_integer;
    return y * power_of_two(half) * power_of_two(k - (half - to_integer) + to_integer);
}
/// e^x as a double with float accuracy: |error| 2^-32, for any x.
inline double exp_short(double x) {
    x = x < -150 ? -150 : x > 130 ? 130 : x;  // both limits are beyond float; NaN is kept
    const double shifted = x * 0x1.71547652b82fep+0 + to_integer, r = x - (shifted - to_integer) * 0x1.62e42fefa39efp-1;
    return (1 + r * (1 + r * exp_tail_short(r))) * power_of_two(shifted);
}
/// e^(x + low) for |low| much smaller than |x|.
inline double exp_of_sum(double x, double low) {
    x = x < -746 ? -746 : x > 710 ? 710 : x;  // both limits are beyond double; NaN is kept
    const PowerOfTwo p = split_exponent(x);
    const double rest = p.r + p.r * p.r * exp_tail(p.r), lower = p.r_low + low;
    return scaled(1 + (rest + lower * (1 + rest)), p.k);
}

/// The parts of a normal number x > 0: x = 2^k m, sqrt(1/2) <= m < sqrt(2).
struct Mantissa {
    double k, m;
};
inline Mantissa split_mantissa(double x) {
    const std::uint64_t bits = bits_of(x), exponent = (bits + (bits_of(1) - bits_of(0x1.6a09e667f3bcdp-1))) >> 52;
    return {std::bit_cast<double>(exponent | bits_of(0x1p52)) - (0x1p52 + 1023),
            std::bit_cast<double>(bits - ((exponent - 1023) << 52))};
}
/// (2 atanh(s) - 2 s) / s^3 as a polynomial in z = s^2, for s = (m - 1) / (m + 1): 2^-65.7 of the logarithm.
inline double log_tail(double z) {
    return polynomial(z, 0x1.5555555555555p-1, 0x1.9999999999ep-2, 0x1.249249242b31cp-2, 0x1.c71c72591067ep-3,
                      0x1.745cde2fa45a8p-3, 0x1.3b20ac996b2a4p-3, 0x1.0f5cb1459a54p-3, 0x1.0f63ec717f86bp-3);
}
/// log(1 + f) + k log(2) + c for 1 + f in the range of a Mantissa.
inline double log_of_parts(double k, double f, double c) {
    const double s = f / (2 + f), z = s * s, half = 0.5 * f * f;
    return k * 0x1.62e42fee00000p-1 - ((half - (s * (half + z * log_tail(z)) + (k * 0x1.a39ef35793c76p-33 + c))) - f);
}
/// log(1 + f) + k log(2) for float: 2^-43.9.
inline double log_short(double k, double f) {
    const double s = f / (2 + f), z = s * s;
    return k * 0x1.62e42fefa39efp-1 +
           s * (2 + z * polynomial(z, 0x1.555555561e27ep-1, 0x1.999996a966cbep-2, 0x1.249411f050936p-2,
                                   0x1.c62b0ff772542p-3, 0x1.9116043b32251p-3));
}
/// The logarithm of an argument that is not a positive number.
inline double log_at_limits(double x, double result) {
    return x > 0 ? (x == infinity ? x : result) : x == 0 ? -infinity : nan;
}
inline double log_short(double x) {
    const Mantissa a = split_mantissa(x);
    return log_at_limits(x, log_short(a.k, a.m - 1));
}

/// (atan(t) / t - 1) / t^2 as a polynomial in t^2, |t| <= tan(pi/8): 2^-59.5 of atan; for float 2^-35.4.
inline double atan_tail(double z) {
    return polynomial(z, -0x1.555555555553dp-2, 0x1.99999999958dep-3, -0x1.24924922b0c7cp-3, 0x1.c71c70e77d9c4p-4,
                      -0x1.745cf906c73d6p-4, 0x1.3b111c142e3c8p-4, -0x1.10ebd9e8bc642p-4, 0x1.df112f973dee5p-5,
                      -0x1.9cdb22d53705dp-5, 0x1.37ea983b419b7p-5, -0x1.25974fe0fa3cap-6);
}
inline double atan_tail_short(double z) {
    return polynomial(z, -0x1.555554c8ec105p-2, 0x1.99991a70a016dp-3, -0x1.247f0933ca9bbp-3, 0x1.c4681f89fd044p-4,
                      -0x1.5b45670e160f8p-4, 0x1.84f38f09b7d5dp-5);
}
/// atan2(y, x) if |y| + |x| neither overflows nor loses digits, as the angle from the nearest multiple of pi/4.
template <class Tail>
double angle(double y, double x, Tail tail) {
    const double ay = std::abs(y), ax = std::abs(x);
    const bool steep = ay > ax;
    const double longer = steep ? ay : ax, shorter = steep ? ax : ay;
    const double most = longer == 0 ? 1 : longer == infinity ? 1 : longer;
    const double least = longer == infinity ? (shorter == infinity ? 1.0 : 0.0) : shorter;
    const bool diagonal = least > 0x1.a827999fcef32p-2 * most;  // tan(pi/8)
    const double t = (diagonal ? least - most : least) / (diagonal ? least + most : most), z = t * t;
    const double small = t + t * (z * tail(z));
    // In eighths of a turn: 0 or 1 from the x axis, 4 or 3 from its negative end, 2 or 1 from the y axis.
    const bool behind = bits_of(x) >> 63 != 0;
    const double eighths = steep ? (diagonal ? 1 : 2) : (diagonal ? 1 : 0);
    const double turned = behind ? 4 - eighths : eighths;
    const double result =
        turned * 0x1.921fb54442d18p-1 + (with_sign_bit(small, steep != behind) + turned * 0x1.1a62633145c07p-55);
    return std::copysign(x != x || y != y ? nan : result, y);
}

/// (asin(s) / s - 1) / s^2 as a polynomial in s^2, |s| <= 1/2: 2^-59.8 of asin; for float 2^-35.8.
inline double asin_tail(double z) {
    return polynomial(z, 0x1.5555555555578p-3, 0x1.333333332df0bp-4, 0x1.6db6db722bcb9p-5, 0x1.f1c71a8b7c6f2p-6,
                      0x1.6e8bdfe9b029fp-6, 0x1.1c49ddcfe9ec6p-6, 0x1.ca21487f7e83cp-7, 0x1.75776dccee19p-7,
                      0x1.618b5b42828c8p-7, 0x1.e1528f46c5d48p-9, 0x1.65046fe0cdbd6p-6, -0x1.59f9ae752813bp-6,
                      0x1.0be550199ce09p-5);
}
inline double asin_tail_short(double z) {
    return polynomial(z, 0x1.5555560942192p-3, 0x1.3332a7e3dd489p-4, 0x1.6ddb302b9c6bap-5, 0x1.ed52779dfc85p-6,
                      0x1.9360ce3b2f0d3p-6, 0x1.e9103e175bae8p-8, 0x1.1c470fb411554p-5);
}
/// asin of x for x <= 1/2, and otherwise of sqrt((1 - x) / 2); asin and acos follow from it.
struct Arc {
    bool far;
    double angle;
    double low;  ///< low part of the square root
};
template <class Tail>
Arc arc_of(double x, Tail tail) {
    const double a = std::abs(x);
    const bool far = a > 0.5;
    const double z = far ? (1 - a) * 0.5 : a * a, s = far ? std::sqrt(z) : a;
    return {far, s, s * (z * tail(z))};
}
constexpr double half_pi = 0x1.921fb54442d18p+0, half_pi_low = 0x1.1a62633145c07p-54;

template <class Tail>
double asin_by(double x, Tail tail) {
    const Arc arc = arc_of(x, tail);
    const double far = half_pi - (2 * arc.angle + (2 * arc.low - half_pi_low));
    return std::copysign(arc.far ? far : arc.angle + arc.low, x);
}
template <class Tail>
double acos_by(double x, Tail tail) {
    const Arc arc = arc_of(x, tail);
    const double near = std::copysign(arc.angle, x), near_low = std::copysign(arc.low, x);
    const double twice = 2 * (arc.angle + arc.low);
    const double far = x < 0 ? 2 * half_pi - (2 * arc.angle + (2 * arc.low - 2 * half_pi_low)) : twice;
    return arc.far || x != x ? far : half_pi - (near - (half_pi_low - near_low));
}

}  // namespace detail

inline SinCos<double> sin_cos(double x) {
    return detail::sin_cos_of(std::abs(x) <= detail::largest_reduced ? detail::reduce(x) : detail::reduce_large(x));
}
inline SinCos<float> sin_cos(float x) {
    return std::abs(x) <= static_cast<float>(detail::largest_reduced) ? detail::sin_cos_near(x)
                                                                      : detail::sin_cos_far(x);
}
inline double sin(double x) {
    return x == 0 ? x : sin_cos(x).sin;
}
inline float sin(float x) {
    return sin_cos(x).sin;
}
inline double cos(double x) {
    return sin_cos(x).cos;
}
inline float cos(float x) {
    return sin_cos(x).cos;
}
inline double tan(double x) {
    const SinCos<double> a = sin_cos(x);
    return x == 0 ? x : a.sin / a.cos;
}
inline float tan(float x) {
    return static_cast<float>(tan(static_cast<double>(x)));
}

inline double exp(double x) {
    return detail::exp_of_sum(x, 0);
}
inline float exp(float x) {
    return static_cast<float>(detail::exp_short(x));
}
inline double exp2(double x) {
    const double limited = x < -1100  ? -1100
                           : x > 1100 ? 1100
                                      : x,
                 k = limited + detail::to_integer - detail::to_integer;
    const double part = limited - k, r = part * 0x1.62e42fefa39efp-1;
    return detail::scaled(1 + (r + (r * r * detail::exp_tail(r) + part * 0x1.abc9e3b39803fp-56)), k);
}
inline float exp2(float x) {
    return static_cast<float>(exp2(static_cast<double>(x)));
}
inline double expm1(double x) {
    const double limited = x < -45 ? -45 : x > 710 ? 710 : x;
    const detail::PowerOfTwo p = detail::split_exponent(limited);
    const double near = p.r + (p.r * p.r * detail::exp_tail(p.r) + (1 + p.r) * p.r_low);
    const double half = detail::power_of_two(p.shifted - 1);  // k can be 1024
    return x == 0 ? x : p.k == 0 ? near : 2 * (half * near + (half - 0.5));
}
inline float expm1(float argument) {
    const double x = argument < -45 ? -45 : argument > 130 ? 130 : argument;
    const detail::PowerOfTwo p = detail::split_exponent(x);
    const double power = detail::power_of_two(p.shifted), near = p.r * (1 + p.r * detail::exp_tail_short(p.r));
    return p.k == 0 ? static_cast<float>(near) : static_cast<float>(power * near + (power - 1));
}

inline double log(double x) {
    const bool denormal = x < std::numeric_limits<double>::min();
    const detail::Mantissa a = detail::split_mantissa(denormal ? x * 0x1p54 : x);
    return detail::log_at_limits(x, detail::log_of_parts(denormal ? a.k - 54 : a.k, a.m - 1, 0));
}
inline float log(float x) {
    return static_cast<float>(detail::log_short(static_cast<double>(x)));
}
inline double log2(double x) {
    const bool denormal = x < std::numeric_limits<double>::min();
    const detail::Mantissa a = detail::split_mantissa(denormal ? x * 0x1p54 : x);
    const double m = detail::log_of_parts(0, a.m - 1, 0), k = denormal ? a.k - 54 : a.k;
    return detail::log_at_limits(x, k + (m * 0x1.7154765200000p+0 + m * 0x1.705fc2eefa200p-33));
}
inline float log2(float x) {
    return static_cast<float>(log2(static_cast<double>(x)));
}
inline double log1p(double x) {
    const double u = 1 + x;
    const detail::Mantissa a = detail::split_mantissa(u);
    const bool near = a.k == 0;  // x itself is in the range of one logarithm
    const double lost = near ? 0 : (a.k > 0 ? 1 - (u - x) : x - (u - 1)) / u;
    return x == 0 ? x : detail::log_at_limits(u, detail::log_of_parts(a.k, near ? x : a.m - 1, lost));
}
inline float log1p(float argument) {
    const double x = argument, u = 1 + x;
    const detail::Mantissa a = detail::split_mantissa(u);
    return static_cast<float>(x == 0 ? x : detail::log_at_limits(u, detail::log_short(a.k, a.k == 0 ? x : a.m - 1)));
}

inline double atan2(double y, double x) {
    // A power of two scales arguments at the ends of the range, which does not change the angle.
    const bool large = std::abs(y) > 0x1p1000 || std::abs(x) > 0x1p1000;
    return detail::angle(large ? y * 0x1p-60 : y, large ? x * 0x1p-60 : x, detail::atan_tail);
}
inline float atan2(float y, float x) {
    return static_cast<float>(detail::angle(y, x, detail::atan_tail_short));
}
inline double atan(double x) {
    return detail::angle(x, 1, detail::atan_tail);
}
inline float atan(float x) {
    return static_cast<float>(detail::angle(x, 1, detail::atan_tail_short));
}
inline double asin(double x) {
    return detail::asin_by(x, detail::asin_tail);
}
inline float asin(float x) {
    return static_cast<float>(detail::asin_by(x, detail::asin_tail_short));
}
inline double acos(double x) {
    return detail::acos_by(x, detail::asin_tail);
}
inline float acos(float x) {
    return static_cast<float>(detail::acos_by(x, detail::asin_tail_short));
}

double pow(double x, double y);
float pow(float x, float y);
double cbrt(double x);

inline double hypot(double x, double y) {
    const double larger = std::abs(x) > std::abs(y) ? std::abs(x) : std::abs(y);
    if (larger > 0x1p-500 && larger < 0x1p500) return std::sqrt(x * x + y * y);
    if (std::abs(x) == detail::infinity || std::abs(y) == detail::infinity) return detail::infinity;
    const double by = larger > 1 ? 0x1p-600 : 0x1p600;
    return std::sqrt((x * by) * (x * by) + (y * by) * (y * by)) / by;
}
inline float hypot(float x, float y) {
    if (std::abs(x) == std::numeric_limits<float>::infinity() || std::abs(y) == std::numeric_limits<float>::infinity())
        return std::numeric_limits<float>::infinity();
    return static_cast<float>(std::sqrt(static_cast<double>(x) * x + static_cast<double>(y) * y));
}

}  // namespace raylex::elementary
