// Prints a number from the bits of the C library's functions, and one from raylex's, for masked_features_test.cpp.
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <initializer_list>

#include "display/services/elementary.h"
#include "display/services/processor.h"

namespace {

namespace elementary = raylex::elementary;

struct Digest {
    std::uint64_t value = 0;
    void add(double x) {
        value = (value ^ std::bit_cast<std::uint64_t>(x)) * 0x9e3779b97f4a7c15u, value ^= value >> 29;
    }
};

}  // namespace

int main() {
    Digest libm, own;
    for (int i = 0; i < 20000; ++i) {
        volatile double argument = i * 0.0123 + 0.001;  // prevents evaluation by the compiler
        const double x = argument;
        const auto y = static_cast<float>(x);
        for (const double value : {std::sin(x), std::exp(-x), std::log(x), std::pow(x, 2.4), std::atan(x), std::tan(x)})
            libm.add(value);
        for (const double value : {elementary::sin(x), elementary::exp(-x), elementary::log(x), elementary::pow(x, 2.4),
                                   elementary::atan(x), elementary::tan(x), elementary::cos(x), elementary::expm1(-x),
                                   elementary::log1p(x), elementary::cbrt(x), elementary::exp2(-x)})
            own.add(value);
        for (const float value : {elementary::sin(y), elementary::exp(-y), elementary::log(y), elementary::pow(y, 2.4f),
                                  elementary::atan(y), elementary::tan(y), elementary::cos(y), elementary::expm1(-y)})
            own.add(value);
    }
    std::printf("fma %s\nlibm %016llx\nown %016llx\n", raylex::display::supports("avx2") ? "yes" : "no",
                static_cast<unsigned long long>(libm.value), static_cast<unsigned long long>(own.value));
}
