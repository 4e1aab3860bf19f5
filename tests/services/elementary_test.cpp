// The elementary functions: their accuracy against the C library in higher precision, their limits, and their exact
// bits, which are the same on every processor (display/services/elementary.h).
#include <catch2/catch.hpp>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "display/services/elementary.h"
#include "display/services/hash64.h"

namespace {

namespace elementary = raylex::elementary;

using Range = std::pair<double, double>;

/// A function of one argument in both precisions, and the C library's function in the next higher precision.
struct Function {
    const char* name;
    float (*single)(float);
    double (*single_reference)(double);
    double (*whole)(double);
    long double (*reference)(long double);
    double bound;  ///< largest error of the double function in ulp: that of the header, rounded up
    std::vector<Range> ranges;
};

#define RAYLEX_FUNCTION(name, bound, ...)                                    \
    Function {                                                               \
#name, [](float x) { return elementary::name(x); },                        \
            [](double x) { return std::name(x); },                                 \
            [](double x) { return elementary::name(x); },                          \
            [](long double x) { return std::name(x); }, bound, { \
            __VA_ARGS__                                                      \
        }                                                                    \
    }

const std::vector<Function>& functions() {
    static const std::vector<Function> all = {
        RAYLEX_FUNCTION(sin, 0.8, {-10, 10}, {-1e6, 1e6}, {1e6, 1e300}),
        RAYLEX_FUNCTION(cos, 0.8, {-10, 10}, {-1e6, 1e6}, {1e6, 1e300}),
        RAYLEX_FUNCTION(tan, 2.2, {-10, 10}, {-1e6, 1e6}, {1e6, 1e300}),
        RAYLEX_FUNCTION(exp, 1.01, {-2, 2}, {-750, 715}),
        RAYLEX_FUNCTION(exp2, 1.01, {-3, 3}, {-1080, 1030}),
        RAYLEX_FUNCTION(expm1, 1.5, {-2, 2}, {-50, 715}, {-1e-3, 1e-3}),
        RAYLEX_FUNCTION(log, 0.9, {0, 1e-3}, {0.5, 2}, {2, 1e300}),
        RAYLEX_FUNCTION(log2, 2.1, {0, 1e-3}, {0.5, 2}, {2, 1e300}),
        RAYLEX_FUNCTION(log1p, 2.1, {-1, 0}, {-1e-3, 1e-3}, {0, 4}, {4, 1e300}),
        RAYLEX_FUNCTION(atan, 2.2, {-1, 1}, {-4, 4}, {4, 1e300}),
        RAYLEX_FUNCTION(asin, 1.7, {-1, 1}, {-1e-3, 1e-3}, {0.999, 1}),
        RAYLEX_FUNCTION(acos, 1.2, {-1, 1}, {-1e-3, 1e-3}, {0.999, 1}),
    };
    return all;
}

/// The unit in the last place of a result with this many bits and this smallest exponent.
double ulp_of(double result, int bits, int least) {
    int exponent = 0;
    std::frexp(result, &exponent);
    return std::ldexp(1.0, std::max(exponent, least) - bits);
}
double float_ulp(double result) {
    return ulp_of(result, 24, -125);
}
double double_ulp(double result) {
    return ulp_of(result, 53, -1021);
}

/// Arguments of which half are spread over the range and half over its exponents.
std::vector<double> arguments(const Range& range, std::size_t count) {
    std::mt19937_64 random(7);
    const auto unit = [&random] { return static_cast<double>(random() >> 11) * 0x1p-53; };
    const double least = std::max(std::abs(range.first), std::abs(range.second) * 1e-18);
    std::vector<double> result;
    for (std::size_t i = 0; i < count; ++i) {
        const double spread = range.first + (range.second - range.first) * unit();
        const double size = range.second * std::pow(std::min(least, range.second) / range.second, unit());
        result.push_back(i % 2 == 0 ? spread : range.first < 0 && i % 4 == 1 ? std::max(-size, range.first) : size);
    }
    return result;
}

/// The largest error of the float function over every `step`th of all floats; -1 if a result that must be infinite, NaN
/// or a zero with a certain sign is wrong.
double float_error(const Function& f, std::uint64_t step) {
    double worst = 0;
    for (std::uint64_t bits = 0; bits < std::uint64_t(1) << 32; bits += step) {
        const float x = std::bit_cast<float>(static_cast<std::uint32_t>(bits)), y = f.single(x);
        const double expected = f.single_reference(x);
        const auto rounded = static_cast<float>(expected);
        if (std::isnan(expected) ? std::isnan(y) : std::isinf(rounded) || expected == 0 ? y == rounded : false) {
            if (expected == 0 && std::signbit(expected) != std::signbit(y)) return -1;
            continue;
        }
        const double error = std::abs(y - expected) / float_ulp(expected);
        if (!(error < 1e9)) return -1;
        worst = std::max(worst, error);
    }
    return worst;
}

template <class Own, class Reference>
double double_error(double x, Own own, Reference reference) {
    const double y = own(x);
    const auto expected = reference(static_cast<long double>(x));
    const auto rounded = static_cast<double>(expected);
    if (std::isinf(rounded)) return y == rounded ? 0 : 1e9;
    return static_cast<double>(std::abs(y - expected)) / double_ulp(rounded);
}

bool same_value(double a, double b) {
    return (std::isnan(a) && std::isnan(b)) || (a == b && std::signbit(a) == std::signbit(b));
}

const double special[] = {0.0,
                          -0.0,
                          1,
                          -1,
                          0.5,
                          -2.5,
                          2,
                          -3,
                          3,
                          1e30,
                          -1e300,
                          0x1p53,
                          std::numeric_limits<double>::infinity(),
                          -std::numeric_limits<double>::infinity(),
                          std::numeric_limits<double>::quiet_NaN(),
                          std::numeric_limits<double>::denorm_min(),
                          -std::numeric_limits<double>::denorm_min()};

/// Returns whether the values are the same zero, infinity or NaN, or numbers within that many ulp.
bool agrees(double own, double expected, double ulps, double ulp) {
    if (!std::isfinite(expected) || expected == 0) return same_value(own, expected);
    return std::abs(own - expected) <= ulps * ulp;
}

}  // namespace

TEST_CASE("float functions are within 0.51 ulp at every float", "[elementary]") {
    for (const Function& f : functions()) {
        INFO(f.name);
        const double error = float_error(f, 19997);  // a prime: all exponents, and mantissas without a pattern
        CHECK(error >= 0.49);                        // the error of a single rounding; less would mean that nothing was
                                                     // measured
        CHECK(error <= 0.51);
    }
}

TEST_CASE("float functions are within 0.51 ulp at all 2^32 floats", "[.full]") {
    for (const Function& f : functions()) {
        const double error = float_error(f, 1);
        WARN(f.name << ": " << error << " ulp");
        CHECK(error >= 0.49);
        CHECK(error <= 0.51);
    }
}

TEST_CASE("double functions have the documented accuracy", "[elementary]") {
    for (const Function& f : functions()) {
        INFO(f.name);
        double worst = 0;
        for (const Range& range : f.ranges)
            for (const double x : arguments(range, 20000))
                worst = std::max(worst, double_error(x, f.whole, f.reference));
        CHECK(worst > 0.4);
        CHECK(worst <= f.bound);
    }
}

TEST_CASE("double functions of two arguments have the documented accuracy", "[elementary]") {
    struct Two {
        const char* name;
        double (*own)(double, double);
        long double (*reference)(long double, long double);
        double bound;
        Range first, second;
    };
    const auto power = [](long double x, long double y) { return std::pow(x, y); };
    const auto direction = [](long double y, long double x) { return std::atan2(y, x); };
    const auto distance = [](long double x, long double y) { return std::hypot(x, y); };
    const Two cases[] = {{"pow", elementary::pow, power, 1.1, {1e-30, 10}, {-20, 20}},
                         {"pow near 1", elementary::pow, power, 1.1, {0.99, 1.01}, {-60000, 60000}},
                         {"atan2", elementary::atan2, direction, 2.2, {-1, 1}, {-1, 1}},
                         {"hypot", elementary::hypot, distance, 1.3, {-1, 1}, {1e-30, 1}}};
    for (const Two& c : cases) {
        INFO(c.name);
        const std::vector<double> xs = arguments(c.first, 40000), ys = arguments(c.second, 40003);
        double worst = 0;
        for (std::size_t i = 0; i < xs.size(); ++i) {
            const double y = ys[(i * 7919) % ys.size()];
            worst = std::max(worst, double_error(
                                        xs[i], [&](double x) { return c.own(x, y); },
                                        [&](long double x) { return c.reference(x, y); }));
        }
        CHECK(worst > 0.4);
        CHECK(worst <= c.bound);
    }
    double worst = 0;
    for (const double x : arguments({-1e3, 1e3}, 40000))
        worst = std::max(
            worst, double_error(
                       x, [](double v) { return elementary::cbrt(v); }, [](long double v) { return std::cbrt(v); }));
    CHECK(worst <= 1);
}

TEST_CASE("sine and cosine next to multiples of pi/2", "[elementary]") {
    for (int k = 1; k < 400000; k += k < 1000 ? 1 : 997) {
        const double x = k * 1.5707963267948966;
        CHECK(double_error(x, functions()[0].whole, functions()[0].reference) <= 0.8);
        CHECK(double_error(x, functions()[1].whole, functions()[1].reference) <= 0.8);
    }
    // The double closest to a multiple of pi/2 (Muller, table 11.1): 6381956970095103 2^797.
    const double x = std::ldexp(6381956970095103.0, 797);
    CHECK(std::abs(elementary::cos(x)) < 0x1p-60);
    CHECK(double_error(x, functions()[1].whole, functions()[1].reference) <= 0.8);
}

TEST_CASE("limits are those of C", "[elementary]") {
    for (const Function& f : functions()) {
        INFO(f.name);
        for (const double x : special) {
            INFO(x);
            const auto expected = static_cast<double>(f.reference(x));
            // `expected` is rounded, too.
            CHECK(agrees(f.whole(x), expected, f.bound + 0.5, double_ulp(expected)));
        }
    }
    for (const double x : special) {
        CHECK(agrees(elementary::cbrt(x), std::cbrt(x), 2, double_ulp(std::cbrt(x))));
        for (const double y : special) {
            INFO(x << " " << y);
            const auto narrow_x = static_cast<float>(x), narrow_y = static_cast<float>(y);
            const double power = std::pow(x, y), narrow_power = std::pow(double{narrow_x}, double{narrow_y});
            CHECK(agrees(elementary::pow(x, y), power, 2, double_ulp(power)));
            CHECK(agrees(elementary::pow(narrow_x, narrow_y), static_cast<float>(narrow_power), 1,
                         float_ulp(narrow_power)));
            const double angle = std::atan2(x, y);
            CHECK(agrees(elementary::atan2(x, y), angle, 3, double_ulp(angle)));
            const double distance = std::hypot(x, y);
            CHECK(agrees(elementary::hypot(x, y), distance, 2, double_ulp(distance)));
        }
    }
}

TEST_CASE("float powers and angles are within 0.51 ulp", "[elementary]") {
    const auto worst_of = [](auto own, auto reference) {
        double worst = 0;
        for (const double a : arguments({-30, 30}, 3000)) {
            for (const double b : {-3.0, -0.01, 0.4166666567325592, 2.4000000953674316, 17.25, 1e-30, -1e20}) {
                const auto x = static_cast<float>(a), y = static_cast<float>(b);
                const double expected = reference(double{x}, double{y});
                if (std::isnan(expected) || std::isinf(static_cast<float>(expected))) continue;
                worst = std::max(worst, std::abs(own(x, y) - expected) / float_ulp(expected));
            }
        }
        return worst;
    };
    using Single = float (*)(float, float);
    CHECK(worst_of(Single(elementary::pow), [](double x, double y) { return std::pow(x, y); }) <= 0.51);
    CHECK(worst_of(Single(elementary::atan2), [](double x, double y) { return std::atan2(x, y); }) <= 0.51);
    CHECK(worst_of(Single(elementary::hypot), [](double x, double y) { return std::hypot(x, y); }) <= 0.51);
}

TEST_CASE("float functions are monotone where the mathematical ones are", "[elementary]") {
    const auto ordered = [](float (*f)(float), float from, float to, float sign) {
        // Runs of neighbouring floats, where only rounding matters.
        const int runs = 400;
        for (int run = 0; run < runs; ++run) {
            float x = from + (to - from) * (static_cast<float>(run) / runs), before = f(x);
            for (int i = 0; i < 500; ++i) {
                x = std::nextafter(x, to);
                const float y = f(x);
                if (sign * (y - before) < 0) return x;
                before = y;
            }
        }
        return std::numeric_limits<float>::quiet_NaN();
    };
    const auto holds = [&](float (*f)(float), float from, float to, float sign) {
        return std::isnan(ordered(f, from, to, sign));
    };
    CHECK(holds(elementary::exp, -80, 80, 1));
    CHECK(holds(elementary::exp, -1e-3f, 1e-3f, 1));
    CHECK(holds(elementary::expm1, -10, 10, 1));
    CHECK(holds(elementary::log, 1e-6f, 2, 1));
    CHECK(holds(elementary::log, 1, 1e6f, 1));
    CHECK(holds(elementary::log1p, -0.9999f, 1, 1));
    CHECK(holds(elementary::sin, -1.57f, 1.57f, 1));
    CHECK(holds(elementary::cos, 0, 3.14f, -1));
    CHECK(holds(elementary::atan, -3, 3, 1));
    CHECK(holds(elementary::asin, -1, 1, 1));
    CHECK(holds(elementary::acos, -1, 1, -1));
}

TEST_CASE("the bits of the results are the same on every machine", "[elementary]") {
    // One hash for all results of a function, recorded on one machine. Any other machine must give the same one,
    // whatever its processor (tests/experiments/masked_features_test.cpp masks features), so it changes only with the
    // source.
    const std::pair<const char*, const char*> expected[] = {
        {"sin", "00d2e9d7e417af35"},  {"cos", "b594c0605edf10cc"},  {"tan", "b51e036e55407d08"},
        {"exp", "8d02f22a889fdd20"},  {"exp2", "e1548def93e6218c"}, {"expm1", "7a4a55fe2a1a43ee"},
        {"log", "48e0e2453d481667"},  {"log2", "25a0d5c7d615eba9"}, {"log1p", "b04dc03fad40377d"},
        {"atan", "e5a6adef20e60e11"}, {"asin", "015dad69c247e994"}, {"acos", "26402b9e77738b7a"}};
    std::size_t i = 0;
    for (const Function& f : functions()) {
        std::string bytes;
        for (const Range& range : f.ranges) {
            for (int k = 0; k < 4096; ++k) {
                const double x = range.first + (range.second - range.first) * (k / 4096.0);
                const double wide = f.whole(x);
                const float narrow = f.single(static_cast<float>(x));
                const auto add = [&bytes](std::uint64_t bits) {
                    for (int shift = 0; shift < 64; shift += 8) bytes += static_cast<char>(bits >> shift);
                };
                add(std::isnan(wide) ? 1 : std::bit_cast<std::uint64_t>(wide));
                add(std::isnan(narrow) ? 1 : std::bit_cast<std::uint32_t>(narrow));
            }
        }
        CHECK(f.name == std::string(expected[i].first));
        CHECK(raylex::hash_text(raylex::hash64(bytes)) == expected[i].second);
        ++i;
    }
}
