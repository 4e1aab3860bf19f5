#include "transport/samplers/sampler.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <vector>

using namespace raylex;
using namespace raylex::transport;

TEST_CASE("every number lies in [0, 1 - 2^-24]", "[samplers]") {
    for (const SamplerKind kind : {SamplerKind::independent, SamplerKind::sobol})
        for (std::uint64_t s = 0; s < 4096; ++s) {
            const PixelSampler sampler(kind, 7, 3, 5, s);
            const Vec2 p = sampler.get_2d(static_cast<std::uint32_t>(s % 97));
            for (const float v : {p.x, p.y, sampler.get_1d(11), sampler.get_random(12)}) {
                REQUIRE(v >= 0.0f);
                REQUIRE(v <= 1 - 0x1p-24f);
            }
        }
}

TEST_CASE("the first 2^k points of every sobol pair fill every elementary interval once", "[samplers]") {
    // The defining property of a (0, m, 2)-net in base 2, which scrambling and index shuffling must keep: exact.
    constexpr int m = 8, n = 1 << m;
    for (std::uint32_t dimension = 0; dimension < 50; ++dimension)
        for (int split = 0; split <= m; ++split) {
            const int nx = 1 << split, ny = n / nx;
            std::vector<int> counts(n, 0);
            for (std::uint64_t s = 0; s < n; ++s) {
                const Vec2 p = PixelSampler(SamplerKind::sobol, 1, 17, 4, s).get_2d(dimension);
                ++counts[static_cast<std::size_t>(static_cast<int>(p.x * static_cast<float>(nx)) * ny +
                                                  static_cast<int>(p.y * static_cast<float>(ny)))];
            }
            for (const int c : counts) REQUIRE(c == 1);
        }
}

TEST_CASE("a number depends on nothing but its key", "[samplers][law3]") {
    const PixelSampler a(SamplerKind::sobol, 1, 2, 3, 1000), b(SamplerKind::sobol, 1, 2, 3, 1000);
    static_cast<void>(a.get_2d(5));
    CHECK(a.get_2d(9) == b.get_2d(9));
    CHECK_FALSE(a.get_2d(9) == a.get_2d(10));
    CHECK_FALSE(a.get_2d(9) == PixelSampler(SamplerKind::sobol, 2, 2, 3, 1000).get_2d(9));
    CHECK_FALSE(a.get_2d(9) == PixelSampler(SamplerKind::sobol, 1, 3, 2, 1000).get_2d(9));
}

TEST_CASE("pairs of different dimensions, and pixels, are uncorrelated", "[samplers]") {
    // Correlation of n = 4096 uniform pairs has standard deviation 1/sqrt(n) = 0.0156; 600 comparisons at 5 sigma give
    // a false alarm once in 3,000 runs, and the seed is fixed.
    constexpr int n = 4096;
    for (const SamplerKind kind : {SamplerKind::independent, SamplerKind::sobol})
        for (std::uint32_t d = 0; d < 300; ++d) {
            double sum = 0;
            for (std::uint64_t s = 0; s < n; ++s) {
                const PixelSampler sampler(kind, 3, 8, 8, s), other(kind, 3, 9, 8, s);
                const double x = sampler.get_2d(d).x - 0.5;
                sum += x * (d % 2 == 0 ? sampler.get_2d(d + 1).x - 0.5 : other.get_2d(d).y - 0.5);
            }
            REQUIRE(std::abs(sum * 12 / n) < 5 / std::sqrt(double(n)));
        }
}

TEST_CASE("sobol integrates a smooth function with less error than independent numbers", "[samplers]") {
    const auto error = [](SamplerKind kind) {
        double squares = 0;
        for (int pixel = 0; pixel < 64; ++pixel) {
            double sum = 0;
            for (std::uint64_t s = 0; s < 64; ++s) {
                const Vec2 p = PixelSampler(kind, 0, pixel, 0, s).get_2d(3);
                sum += p.x * p.y;
            }
            squares += std::pow(sum / 64 - 0.25, 2);
        }
        return squares;
    };
    // 64 points: variance falls from n^-1 to about n^-3; a factor of 50 leaves an order of magnitude of room.
    CHECK(error(SamplerKind::sobol) * 50 < error(SamplerKind::independent));
}

TEST_CASE("sampler directives: counts, aliases, errors", "[samplers]") {
    SceneEntity entity;
    entity.type = "zsobol";
    CHECK(choose_sampler(entity)->samples_per_pixel == 16);
    CHECK(choose_sampler(entity)->warnings.empty());
    entity.type = "stratified";
    CHECK(choose_sampler(entity)->samples_per_pixel == 16);
    CHECK(choose_sampler(entity)->warnings.size() == 1);
    entity.type = "soboll";
    REQUIRE_FALSE(choose_sampler(entity).ok());
    CHECK(choose_sampler(entity).error().hint.find("sobol") != std::string::npos);
    entity.type = "sobol";
    Parameter p;
    p.name = "pixelsamples";
    p.type = ParameterType::integer;
    p.numbers = {0};
    entity.parameters.parameters.push_back(p);
    CHECK_FALSE(choose_sampler(entity).ok());
}
