#include "display/buffer/fixed_point.h"

#include <limits>

#include <catch2/catch.hpp>

#include "tests/services/helpers.h"

namespace raylex::display {
namespace {

/// The conversion by the language's arithmetic, exact for |value| < 2^(62 + quantum).
bool by_long_double(double value, int quantum, Int128& out) {
    const long double scaled = std::ldexp(static_cast<long double>(value), -quantum);
    if (!(std::abs(scaled) < 0x1p62L)) return false;
    out = static_cast<Int128>(std::llrint(scaled));  // ties to even
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

TEST_CASE("values near half a quantum round to nearest, ties to even", "[fixed_point]") {
    for (const double half : {0x1p-81, 3 * 0x1p-81, 5 * 0x1p-81, 0x1.8p-80}) {
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
        // 53 bits that end between 2^-80 and 2^46.
        const double value = std::ldexp(random.uniform() - 0.5, random.below(73) - 26);
        Int128 fixed = 0;
        REQUIRE(to_fixed(value, -80, fixed));
        if (static_cast<double>(to_long_double(fixed, -80)) != value) FAIL("differs: " << value);
    }
}

TEST_CASE("a sum of arrays is the sum of the converted numbers", "[fixed_point]") {
    test::Random random(11);
    const auto sums = [&]<std::size_t count>(int quantum, int highest, int span) {
        FixedSum<count> sum(quantum);
        std::array<Int128, count> expected{};
        for (int i = 0; i < 4096; ++i) {
            std::array<double, count> values;
            for (double& value : values) {
                value = std::ldexp(random.uniform() - 0.5, highest + quantum - random.below(span));
                if (random.below(20) == 0) value = 0;
                if (random.below(20) == 0) value = std::ldexp(random.below(64) - 32, quantum - 1);  // includes ties
            }
            REQUIRE(sum.add(values));
            for (std::size_t c = 0; c < count; ++c) {
                Int128 fixed = 0;
                REQUIRE(to_fixed(values[c], quantum, fixed));
                expected[c] += fixed;
            }
        }
        CHECK((sum.total() == expected));
    };
    for (const int quantum : {-80, -56, 0, 3}) {
        sums.operator()<3>(quantum, 109, 160);
        sums.operator()<1>(quantum, 110, 1);
        sums.operator()<1>(quantum, 60, 80);
        sums.operator()<3>(quantum, 20, 40);
    }
}

TEST_CASE("a sum of arrays refuses arrays that are too large or not finite", "[fixed_point]") {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    FixedSum<3> sum(-80);
    for (const double bad : {infinity, -infinity, std::nan(""), 0x1p30, -0x1p30, 0x1p1000})
        for (std::size_t at = 0; at < 3; ++at) {
            std::array<double, 3> values{1, 2, 3};
            values[at] = bad;
            CAPTURE(bad, at);
            CHECK_FALSE(sum.add(values));
        }
    CHECK((sum.total() == std::array<Int128, 3>{}));
    CHECK(sum.add({0x1p29, -1, 1}));
    const Int128 one = static_cast<Int128>(1) << 80;
    CHECK((sum.total() == std::array<Int128, 3>{one << 29, -one, one}));
}

TEST_CASE("fixed point converts to the nearest long double", "[fixed_point]") {
    test::Random random(9);
    for (int i = 0; i < 100'000; ++i) {
        const Int128 fixed =
            ((static_cast<Int128>(random.bits()) << 64) | static_cast<Int128>(random.bits())) >> random.below(127);
        if (as_long_double(fixed) != static_cast<long double>(fixed)) FAIL("differs after " << i);
        const int exponent = random.below(2400) - 1200;  // beyond the range of double, within the range of long double
        if (to_long_double(fixed, exponent) != std::ldexp(static_cast<long double>(fixed), exponent))
            FAIL("2^" << exponent);
    }
}

TEST_CASE("values that do not fit are refused, never wrapped", "[fixed_point][law6]") {
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
