#include "display/buffer/fixed_point.h"

#include <limits>

#include <catch2/catch.hpp>

#include "tests/services/helpers.h"

namespace raylex::display {
namespace {

/// The same conversion by the arithmetic of the language: exact for |value| < 2^(62 + quantum).
bool by_long_double(double value, int quantum, Int128& out) {
    const long double scaled = std::ldexp(static_cast<long double>(value), -quantum);
    if (!(std::abs(scaled) < 0x1p62L)) return false;
    out = static_cast<Int128>(std::llround(scaled));  // ties away from zero
    return true;
}

TEST_CASE("every double converts to the nearest multiple of the quantum", "[fixed_point]") {
    test::Random random(7);
    int compared = 0, wrong = 0;
    for (int i = 0; i < 1'000'000; ++i) {
        const double value = std::bit_cast<double>(random.bits());
        for (const int quantum : {-80, -56, -1, 0, 3}) {
            Int128 expected = 0;
            if (!std::isfinite(value) || !by_long_double(value, quantum, expected)) continue;
            Int128 fixed = 1;
            ++compared;
            wrong += !to_fixed(value, quantum, fixed) || fixed != expected;
        }
    }
    CHECK(compared > 1'000'000);
    CHECK(wrong == 0);
}

TEST_CASE("values near half a quantum round to nearest, ties away from zero", "[fixed_point]") {
    for (const double half : {0x1p-81, 3 * 0x1p-81, 0x1.8p-80}) {
        for (const double value : {half, -half, std::nextafter(half, 0.0), std::nextafter(half, 1.0)}) {
            Int128 fixed = 0, expected = 1;
            REQUIRE(by_long_double(value, -80, expected));
            REQUIRE(to_fixed(value, -80, fixed));
            CHECK(static_cast<long long>(fixed) == static_cast<long long>(expected));
        }
    }
}

TEST_CASE("doubles without bits below the quantum come back exactly", "[fixed_point]") {
    test::Random random(8);
    for (int i = 0; i < 100'000; ++i) {
        // 53 bits ending at 2^-80 at the lowest, 2^46 at the highest.
        const double value = std::ldexp(random.uniform() - 0.5, random.below(73) - 26);
        Int128 fixed = 0;
        REQUIRE(to_fixed(value, -80, fixed));
        if (static_cast<double>(to_long_double(fixed, -80)) != value) FAIL("differs: " << value);
    }
}

TEST_CASE("fixed point becomes the nearest long double", "[fixed_point]") {
    test::Random random(9);
    for (int i = 0; i < 100'000; ++i) {
        const Int128 fixed = ((static_cast<Int128>(random.bits()) << 64) | static_cast<Int128>(random.bits())) >> random.below(127);
        if (as_long_double(fixed) != static_cast<long double>(fixed)) FAIL("differs after " << i);
        const int exponent = random.below(2400) - 1200;  // beyond the range of double, within that of long double
        if (to_long_double(fixed, exponent) != std::ldexp(static_cast<long double>(fixed), exponent)) FAIL("2^" << exponent);
    }
}

TEST_CASE("what does not fit is refused, never wrapped", "[fixed_point][law6]") {
    Int128 fixed = 5;
    for (const double value : {std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
                               std::numeric_limits<double>::quiet_NaN(), 0x1p46, -0x1p46, 1e300})
        CHECK_FALSE(to_fixed(value, -80, fixed));
    CHECK(static_cast<int>(fixed) == 5);
    CHECK(to_fixed(std::nextafter(0x1p46, 0.0), -80, fixed));
    CHECK(to_fixed(0.0, -1074, fixed));
    CHECK(to_fixed(std::numeric_limits<double>::denorm_min(), -1074, fixed));
    CHECK(static_cast<int>(fixed) == 1);
    Int128 sum = 0;
    REQUIRE(to_fixed(std::nextafter(0x1p46, 0.0), -80, sum));
    const Int128 term = sum;
    CHECK(add_fixed(sum, term));
    CHECK_FALSE((add_fixed(sum, sum) && add_fixed(sum, sum)));
}

}  // namespace
}  // namespace raylex::display
