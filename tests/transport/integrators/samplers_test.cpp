#include "transport/samplers/sampler_batch.h"
#include "transport/scene/sampler.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

using namespace raylex;
using namespace raylex::transport;

TEST_CASE("every number lies in [0, 1 - 2^-24]", "[samplers]") {
    for (const SamplerKind kind : {SamplerKind::independent, SamplerKind::sobol, SamplerKind::zsobol})
        for (std::uint64_t s = 0; s < 4096; ++s) {
            const PixelSampler sampler(kind, 7, 3, 5, s);
            const Vec2 p = sampler.get_2d(static_cast<std::uint32_t>(s % 97));
            for (const float v : {p.x, p.y, sampler.get_1d(11), sampler.get_random(12)}) {
                REQUIRE(v >= 0.0f);
                REQUIRE(v <= 1 - 0x1p-24f);
            }
        }
}

namespace {

/// Whether every elementary interval of volume 1/n holds one point: the defining property of a (0, m, 2)-net in base 2,
/// which scrambling and index shuffling must keep. Exact.
bool is_net(const std::vector<Vec2>& points) {
    const std::size_t n = points.size();
    for (std::size_t nx = 1; nx <= n; nx *= 2) {
        std::vector<int> counts(n, 0);
        const std::size_t ny = n / nx;
        for (const Vec2& p : points)
            ++counts[static_cast<std::size_t>(p.x * static_cast<float>(nx)) * ny +
                     static_cast<std::size_t>(p.y * static_cast<float>(ny))];
        if (std::find_if(counts.begin(), counts.end(), [](int c) { return c != 1; }) != counts.end()) return false;
    }
    return true;
}

}  // namespace

TEST_CASE("the first 2^k points of every sobol pair fill every elementary interval once", "[samplers]") {
    for (std::uint32_t dimension = 0; dimension < 50; ++dimension) {
        std::vector<Vec2> points;
        for (std::uint64_t s = 0; s < 256; ++s)
            points.push_back(PixelSampler(SamplerKind::sobol, 1, 17, 4, s).get_2d(dimension));
        REQUIRE(is_net(points));
    }
}

TEST_CASE("zsobol: 2^k samples of a pixel are a net, and those of a square of pixels together", "[samplers]") {
    for (const std::uint32_t bits : {0u, 3u, 4u, 6u})
        for (std::uint32_t dimension = 0; dimension < 20; ++dimension) {
            const auto points = [&](int x0, int y0, int side, std::uint64_t first, std::uint64_t end) {
                std::vector<Vec2> result;
                for (int y = y0; y < y0 + side; ++y)
                    for (int x = x0; x < x0 + side; ++x)
                        for (std::uint64_t s = first; s < end; ++s)
                            result.push_back(PixelSampler(SamplerKind::zsobol, 5, x, y, s, bits).get_2d(dimension));
                return result;
            };
            const std::uint64_t n = std::uint64_t{1} << bits;
            for (std::uint64_t k = 1; k <= n; k *= 2) REQUIRE(is_net(points(77, 31, 1, 0, k)));
            for (std::uint64_t first = n; first < 8 * n; first *= 2)  // more than was arranged for: nets of their own
                REQUIRE(is_net(points(-3, 1000000, 1, first, 2 * first)));
            for (const int side : {2, 4, 8}) {
                REQUIRE(is_net(points(5 * side, 12 * side, side, 0, n)));
                REQUIRE(is_net(points(-3 * side, 70000 * side, side, n, 2 * n)));
            }
        }
}

namespace {

/// Squared error of the mean of a smooth function over a square of pixels, 16 samples each, in the mean over seeds.
double error_of_square(SamplerKind kind, int side, std::uint64_t seeds) {
    double squares = 0;
    for (std::uint64_t seed = 0; seed < seeds; ++seed) {
        double sum = 0;
        for (int i = 0; i < side * side; ++i)
            for (std::uint64_t s = 0; s < 16; ++s) {
                const Vec2 p = PixelSampler(kind, seed, 8 + i % side, 12 + i / side, s).get_2d(3);
                sum += p.x * p.y;
            }
        squares += std::pow(sum / (16.0 * side * side) - 0.25, 2) / static_cast<double>(seeds);
    }
    return squares;
}

}  // namespace

TEST_CASE("zsobol: neighbours bring what a pixel misses", "[samplers]") {
    // 4 x 4 pixels together are one net of 256 points, whose variance falls as n^-3 beside n^-1 of independent pixels:
    // by 16^2. Half of that, for a mean of 256 squared errors is off by a tenth.
    CHECK(error_of_square(SamplerKind::zsobol, 4, 256) * 128 < error_of_square(SamplerKind::sobol, 4, 256));
    // A pixel by itself is as with sobol. Squares of normal errors deviate by sqrt(2) of their mean: the ratio of the
    // means of 4096 by 2 / sqrt(4096) = 0.031; four of them.
    CHECK(std::abs(error_of_square(SamplerKind::zsobol, 1, 4096) / error_of_square(SamplerKind::sobol, 1, 4096) - 1) <
          0.125);
}

TEST_CASE("a number depends on nothing but its key", "[samplers][law3]") {
    const PixelSampler a(SamplerKind::sobol, 1, 2, 3, 1000), b(SamplerKind::sobol, 1, 2, 3, 1000);
    static_cast<void>(a.get_2d(5));
    CHECK(a.get_2d(9) == b.get_2d(9));
    CHECK_FALSE(a.get_2d(9) == a.get_2d(10));
    CHECK_FALSE(a.get_2d(9) == PixelSampler(SamplerKind::sobol, 2, 2, 3, 1000).get_2d(9));
    CHECK_FALSE(a.get_2d(9) == PixelSampler(SamplerKind::sobol, 1, 3, 2, 1000).get_2d(9));
    const PixelSampler z(SamplerKind::zsobol, 1, 2, 3, 9, 4);
    CHECK(z.get_2d(9) == PixelSampler(SamplerKind::zsobol, 1, 2, 3, 9, 4).get_2d(9));
    CHECK_FALSE(z.get_2d(9) == PixelSampler(SamplerKind::zsobol, 2, 2, 3, 9, 4).get_2d(9));
    CHECK_FALSE(z.get_2d(9) == PixelSampler(SamplerKind::zsobol, 1, 3, 2, 9, 4).get_2d(9));
    CHECK_FALSE(z.key(9) == PixelSampler(SamplerKind::zsobol, 1, 3, 2, 9, 4).key(9));
}

TEST_CASE("pairs drawn together have the bits of those drawn one by one", "[samplers]") {
    CHECK_FALSE(SamplerBatch::takes(PixelSampler(SamplerKind::independent, 1, 2, 3, 4)));
    if (!SamplerBatch::takes(PixelSampler(SamplerKind::sobol, 1, 2, 3, 4))) {
        WARN("this machine draws them one by one: nothing to compare");
        return;
    }
    SamplerBatch batch(70);
    for (std::size_t count = 0; count <= 70; ++count) {  // whole vectors and what is left beside them
        std::vector<PixelSampler> samplers;
        std::vector<std::uint32_t> dimensions;
        for (std::uint32_t i = 0; i < count; ++i) {
            const SamplerKind kind = i % 3 == 0 ? SamplerKind::zsobol : SamplerKind::sobol;
            const std::uint64_t sample = i % 5 == 0 ? (std::uint64_t{1} << 33) + i : i * count;
            samplers.emplace_back(kind, 7 + i % 2, static_cast<int>(i % 11) - 3, 1000 - static_cast<int>(i), sample);
            dimensions.push_back(i % 7 == 0 ? (1u << 26) + i : i * 5);
        }
        batch.clear();
        for (std::size_t i = 0; i < count; ++i) batch.add(samplers[i], dimensions[i]);
        batch.draw();
        for (std::size_t i = 0; i < count; ++i) {
            CAPTURE(count, i);
            const Vec2 alone = samplers[i].get_2d(dimensions[i]);
            REQUIRE(batch[i].x == alone.x);
            REQUIRE(batch[i].y == alone.y);
        }
    }
}

TEST_CASE("pairs of different dimensions, and pixels, are uncorrelated", "[samplers]") {
    // Correlation of n = 4096 uniform pairs has standard deviation 1/sqrt(n) = 0.0156; 600 comparisons at 5 sigma give
    // a false alarm once in 3,000 runs, and the seed is fixed.
    constexpr int n = 4096;
    for (const SamplerKind kind : {SamplerKind::independent, SamplerKind::sobol, SamplerKind::zsobol})
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
    entity.type = "paddedsobol";
    CHECK(choose_sampler(entity)->samples_per_pixel == 16);
    CHECK(choose_sampler(entity)->kind == SamplerKind::sobol);
    CHECK_FALSE(choose_sampler(entity)->stands_in);
    entity.type = "stratified";
    CHECK(choose_sampler(entity)->samples_per_pixel == 16);
    CHECK(choose_sampler(entity)->stands_in);
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

TEST_CASE("zsobol is arranged by what its directive says, whatever a job takes", "[samplers]") {
    SceneEntity entity;
    entity.type = "zsobol";
    CHECK(choose_sampler(entity)->kind == SamplerKind::zsobol);
    CHECK(choose_sampler(entity)->arrangement_bits == 4);
    CHECK_FALSE(choose_sampler(entity)->stands_in);
    const auto add = [&](const char* name, double value) {
        Parameter p;
        p.name = name;
        p.type = ParameterType::integer;
        p.numbers = {value};
        entity.parameters.parameters.push_back(p);
    };
    add("pixelsamples", 100);
    CHECK(choose_sampler(entity)->arrangement_bits == 7);
    add("arranged", 1);
    CHECK(choose_sampler(entity)->arrangement_bits == 0);
    entity.parameters.parameters.back().numbers = {0x1p31};
    CHECK(choose_sampler(entity)->arrangement_bits == 31);
    for (const double none : {0.0, 0x1p32}) {
        entity.parameters.parameters.back().numbers = {none};
        REQUIRE_FALSE(choose_sampler(entity).ok());
        CHECK(choose_sampler(entity).error().message.find("'arranged'") != std::string::npos);
    }
}
