// Forecasts of errors against closed forms, for pixels of value `base`, some of which have found one bright sample.
#include <catch2/catch.hpp>

#include <cmath>
#include <vector>

#include "display/buffer/adaptive/error_forecast.h"

using namespace raylex::display;

namespace {

constexpr double n = 64, base = 0.5;

/// `bright(x, y)` selects the pixels that have found a sample that adds `x_over_base` x base to their mean. If all but
/// one of n samples are 0, the variance of the mean is the square of the mean.
template <class Bright>
std::vector<PixelMoments> pixels_with(int width, int height, double x_over_base, Bright bright) {
    std::vector<PixelMoments> pixels;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const double more = bright(x, y) ? x_over_base * base : 0;
            pixels.push_back({base + more, more * more, n});
        }
    return pixels;
}

/// The squared error of a pixel that has found one such sample among k times as many.
double square_after(double x_over_base, double k) {
    const double share = x_over_base / k;
    return share * share / ((1 + share) * (1 + share));
}

}  // namespace

TEST_CASE("errors without rare samples fall with the root of the samples", "[forecast]") {
    // 13 x 10: pools at the right and at the bottom are smaller. The image has two parts.
    const std::vector<PixelMoments> all(13 * 10, PixelMoments{2, 0.04, n});
    ErrorForecast forecast;
    CHECK(forecast.empty());
    forecast.add({std::span(all).first(13 * 4), 13, 4, 0.2});
    forecast.add({std::span(all).subspan(13 * 4), 13, 6, 0.2});
    // The current error is 0.2 / 2. 1e-12 allows for rounding of logarithms and sums.
    for (const double ratio : {1.5, 2.0, 7.0, 100.0}) {
        const Forecast samples = forecast.samples_to(0.1 / ratio);
        CHECK(samples.expected == Approx(n * ratio * ratio).epsilon(1e-12));
        CHECK(forecast.error_after(samples.expected) == Approx(0.1 / ratio).epsilon(1e-12));
    }
    CHECK(forecast.samples_to(0.2).expected == n);  // at least the current number
    CHECK(forecast.error_after(n / 4) == Approx(0.2).epsilon(1e-12));
    ErrorForecast weighted(3);
    weighted.add({all, 13, 10, 0.2});
    CHECK(weighted.samples_to(0.1).expected == Approx(9 * n).epsilon(1e-12));
}

TEST_CASE("errors from samples that most pixels have not found are forecast until all have found them", "[forecast]") {
    // One pixel of sixteen has found one. With 4 n samples one of four will have found one, with 16 n all; then E is
    // constant. For this x, E grows as n^0.4 up to 4 n: the squared error falls to 4^-0.6, which is 4 (1 + x)^2 / (4 +
    // x)^2.
    const double root = std::pow(4, -0.8), x = (4 * root - 1) / (1 - root);
    const auto pixels = pixels_with(64, 64, x, [](int px, int py) { return px % 4 == 1 && py % 4 == 2; });
    ErrorForecast forecast;
    forecast.add({pixels, 64, 64, 0});
    const double now = square_after(x, 1) / 16, four = square_after(x, 4) / 4, sixteen = square_after(x, 16);
    CHECK(forecast.error_after(n) == Approx(std::sqrt(now)).epsilon(1e-12));
    CHECK(forecast.error_after(4 * n) == Approx(std::sqrt(four)).epsilon(1e-12));
    CHECK(forecast.error_after(16 * n) == Approx(std::sqrt(sixteen)).epsilon(1e-12));
    CHECK(forecast.samples_to(std::sqrt(now * std::pow(2, -0.6))).expected == Approx(2 * n).epsilon(1e-12));
    const Forecast far = forecast.samples_to(std::sqrt(sixteen / 50));
    CHECK(far.expected == Approx(16 * n * 50).epsilon(1e-12));
    CHECK(far.least == 0);  // every part of the image agrees, with four samples
    // The current error alone would predict less than half of that.
    CHECK(far.expected > 2 * samples_to_error(n, std::sqrt(now), std::sqrt(sixteen / 50)));
}

TEST_CASE("pixels with different expected values are not pooled", "[forecast]") {
    std::vector<PixelMoments> pixels;
    for (int i = 0; i < 64 * 64; ++i)
        pixels.push_back(i % 2 == 0 ? PixelMoments{1, 1e-4, n} : PixelMoments{5, 25e-4, n});
    PooledErrors pools(pixels, 64, 64, 0);
    do
        for (const double each : pools.squares()) REQUIRE(each == Approx(n * 1e-4).epsilon(1e-12));
    while (pools.grow());
    CHECK(pools.edge() == PooledErrors::largest_edge);
}

TEST_CASE("if few pixels dominate, the forecast is only a bound", "[forecast]") {
    const auto pixels = pixels_with(64, 64, 100, [](int px, int py) { return px == 20 && (py == 9 || py == 40); });
    ErrorForecast forecast;
    forecast.add({pixels, 64, 64, 0});
    const Forecast samples = forecast.samples_to(forecast.error_after(n) / 8);
    // Two of 64 parts: the standard error of the sum is about 1 / sqrt(2) of it, up to 64 / 63 and the mean.
    CHECK(samples.least > 0);
    CHECK(samples.least < 0.5 * samples.expected);
    // One pixel alone in a pool: its variance is the pool's, so its own deviation is the pool's deviation.
    PooledErrors pools(pixels, 64, 64, 0);
    REQUIRE(pools.grow());
    CHECK(pools.scatter()[9 * 64 + 20] == Approx(1).epsilon(1e-12));
    CHECK(pools.samples(20, 9) == 4 * n);
}

TEST_CASE("if one sample dominates every pool, the forecast is only a bound", "[forecast]") {
    for (const int apart : {4, 8}) {
        const auto pixels = pixels_with(64, 64, 4, [&](int px, int py) { return px % apart == 1 && py % apart == 2; });
        ErrorForecast forecast;
        forecast.add({pixels, 64, 64, 0});
        // Four samples in a pool of 8 x 8 pixels scatter by less than half, because there are only 64; one scatters by
        // all of it.
        CHECK(forecast.few_samples_decide() == (apart == 8));
        const Forecast samples = forecast.samples_to(forecast.error_after(n) / 20);
        // The parts do not scatter: at least the expected value, up to the root of a rounding error.
        CHECK(samples.least == Approx(apart == 8 ? samples.expected : 0).epsilon(1e-6));
    }
}

TEST_CASE("a black image has no error now or later", "[forecast]") {
    const std::vector<PixelMoments> pixels(16, PixelMoments{0, 0, n});
    const double dark = darkest(pixels, 0.1);
    ErrorForecast forecast;
    forecast.add({pixels, 4, 4, dark});
    CHECK(forecast.samples_to(0.01).expected == n);
    CHECK(forecast.error_after(4 * n) == 0);
}

TEST_CASE("a power law between two points is crossed at the right place, and nowhere without samples", "[forecast]") {
    // 1 / n: a quarter of the square takes four times the samples. 1e-12 allows for rounding of logarithms.
    CHECK(crossing({16, 1}, {1024, 1.0 / 64}, 0.25).value() == Approx(64).epsilon(1e-12));
    CHECK_FALSE(crossing({16, 1}, {1024, 0.5}, 0.25));
    CHECK_FALSE(crossing({16, 0.2}, {1024, 0.1}, 0.25));
    CHECK_FALSE(crossing({0, 1}, {64, 0.1}, 0.25));
}
