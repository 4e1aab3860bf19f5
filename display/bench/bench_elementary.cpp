// Measures the time per call of raylex's elementary functions and of the C library's: bench_elementary [rounds, default
// 40].
//
// Arguments are 4096 random numbers of a typical range, and results are added up. So it measures throughput with some
// latency, as in a renderer's loops. The fastest round counts.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <vector>

#include "display/services/elementary.h"

namespace {

namespace elementary = raylex::elementary;

int rounds = 40;

template <class Real, class Function>
double nanoseconds(Function function, Real from, Real to) {
    constexpr int repeats = 20, count = 4096;
    std::mt19937 random(1);
    std::vector<Real> arguments(count);
    for (Real& x : arguments) x = from + (to - from) * static_cast<Real>(random() >> 8) * Real(0x1p-24);
    double best = 1e30;
    for (int round = 0; round < rounds; ++round) {
        const auto start = std::chrono::steady_clock::now();
        Real sum = 0;
        for (int repeat = 0; repeat < repeats; ++repeat)
            for (const Real x : arguments) sum += function(x);
        volatile Real kept = sum;
        static_cast<void>(kept);
        const std::chrono::duration<double, std::nano> time = std::chrono::steady_clock::now() - start;
        best = std::min(best, time.count() / (repeats * count));
    }
    return best;
}

template <class Real, class Own, class Library>
void compare(const char* name, Real from, Real to, Own own, Library library) {
    const double ours = nanoseconds<Real>(own, from, to), theirs = nanoseconds<Real>(library, from, to);
    std::printf("%-6s %-7s %6.2f ns   library %6.2f ns   %.2f\n", sizeof(Real) == 4 ? "float" : "double", name, ours,
                theirs, ours / theirs);
}

template <class Real>
void compare_all() {
    const Real y = Real(2.4);
#define RAYLEX_COMPARE(name, from, to) \
    compare<Real>(                     \
        #name, from, to, [](Real x) { return elementary::name(x); }, [](Real x) { return std::name(x); })
    RAYLEX_COMPARE(sin, 0, Real(6.28));
    RAYLEX_COMPARE(cos, 0, Real(6.28));
    RAYLEX_COMPARE(tan, -1, 1);
    RAYLEX_COMPARE(exp, -5, 5);
    RAYLEX_COMPARE(exp2, -5, 5);
    RAYLEX_COMPARE(expm1, -2, 1);
    RAYLEX_COMPARE(log, Real(1e-3), 5);
    RAYLEX_COMPARE(log2, Real(1e-3), 5);
    RAYLEX_COMPARE(log1p, Real(-0.999), 0);
    RAYLEX_COMPARE(atan, -3, 3);
    RAYLEX_COMPARE(asin, -1, 1);
    RAYLEX_COMPARE(acos, -1, 1);
#undef RAYLEX_COMPARE
    compare<Real>(
        "sin+cos", 0, Real(6.28),
        [](Real x) {
            const auto a = elementary::sin_cos(x);
            return a.sin + a.cos;
        },
        [](Real x) { return std::sin(x) + std::cos(x); });
    compare<Real>(
        "atan2", -1, 1, [](Real x) { return elementary::atan2(x, Real(0.7)); },
        [](Real x) { return std::atan2(x, Real(0.7)); });
    compare<Real>(
        "pow", 0, 1, [y](Real x) { return elementary::pow(x, y); }, [y](Real x) { return std::pow(x, y); });
    compare<Real>(
        "hypot", -1, 1, [](Real x) { return elementary::hypot(x, Real(0.7)); },
        [](Real x) { return std::hypot(x, Real(0.7)); });
}

}  // namespace

int main(int argc, char** argv) {
    if (argc > 1) rounds = std::max(1, std::atoi(argv[1]));
    compare_all<float>();
    compare_all<double>();
}
