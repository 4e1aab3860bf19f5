#include "display/buffer/pixel_filter.h"

#include <array>
#include <functional>
#include <map>
#include <numbers>

#include <catch2/catch.hpp>

#include "tests/services/helpers.h"

namespace raylex::display {
namespace {

using test::Random;

/// The formulas of the kernels, independent of the tested code: radius and one axis of the unnormalised kernel.
struct Kernel {
    double radius;
    std::function<double(double)> value;
};

double lowered_gaussian(double x) {
    return std::exp(-2 * x * x) - std::exp(-2 * 1.5 * 1.5);
}  // sigma 0.5

double mitchell_third(double x) {  // B = C = 1/3, x in [0, 2]: Mitchell and Netravali 1988
    return x < 1 ? (7 * x * x * x - 12 * x * x + 16.0 / 3) / 6
                 : (-7.0 / 3 * x * x * x + 12 * x * x - 20 * x + 32.0 / 3) / 6;
}

double sinc(double x) {
    return x == 0 ? 1 : std::sin(std::numbers::pi * x) / (std::numbers::pi * x);
}

double blackman_harris(double x) {
    const double p = 2 * std::numbers::pi * (x / 3 + 0.5);
    return 0.35875 - 0.48829 * std::cos(p) + 0.14128 * std::cos(2 * p) - 0.01168 * std::cos(3 * p);
}

const std::map<std::string, Kernel>& kernels() {
    static const std::map<std::string, Kernel> all{
        {"box", {0.5, [](double) { return 1.0; }}},
        {"triangle", {2.0, [](double x) { return 2 - std::abs(x); }}},
        {"gaussian", {1.5, lowered_gaussian}},
        {"mitchell", {2.0, [](double x) { return mitchell_third(std::abs(x)); }}},
        {"blackman-harris", {1.5, blackman_harris}},
        {"sinc", {4.0, [](double x) { return sinc(x) * sinc(x / 3); }}},
    };
    return all;
}

double integrate(const std::function<double(double)>& f, double from, double to, int steps) {
    double sum = 0;  // midpoint rule
    for (int i = 0; i < steps; ++i) sum += f(from + (to - from) * (i + 0.5) / steps);
    return sum * (to - from) / steps;
}

TEST_CASE("every filter has pbrt's default radius and only the oscillating ones have negative lobes",
          "[pixel_filter]") {
    CHECK(pixel_filter_registry().names().size() == kernels().size());
    for (const auto& [name, kernel] : kernels()) {
        CAPTURE(name);
        const Result<PixelFilter> filter = make_pixel_filter(name, {});
        REQUIRE(filter);
        CHECK(static_cast<double>(filter->radius_x()) == kernel.radius);
        CHECK(static_cast<double>(filter->radius_y()) == kernel.radius);
        CHECK(filter->has_negative_lobes() == (name == "mitchell" || name == "sinc"));
    }
}

TEST_CASE("evaluate is the kernel's formula, normalised", "[pixel_filter]") {
    for (const auto& [name, kernel] : kernels()) {
        CAPTURE(name);
        const PixelFilter filter = *make_pixel_filter(name, {});
        const double integral = integrate(kernel.value, -kernel.radius, kernel.radius, 100'000);
        const double peak = kernel.value(0) / integral;
        for (int i = -99; i <= 99; ++i) {
            const double x = kernel.radius * i / 100, y = kernel.radius * (i * 37 % 100) / 100;
            const double expected = kernel.value(x) * kernel.value(y) / (integral * integral);
            // 256 linear pieces per radius (1024 for sinc): relative to the peak, h^2 f'' / 8 is at most 1e-4.
            CHECK(std::abs(static_cast<double>(filter.evaluate(static_cast<float>(x), static_cast<float>(y))) -
                           expected) < 1e-4 * peak * peak);
        }
        CHECK(filter.evaluate(filter.radius_x() * 1.01f, 0) == 0.0f);
    }
}

TEST_CASE("the mean of the weights is 1, and every weight of a positive kernel is 1", "[pixel_filter]") {
    for (const auto& [name, kernel] : kernels()) {
        CAPTURE(name);
        const PixelFilter filter = *make_pixel_filter(name, {});
        constexpr int strata = 1 << 18;
        double along_x = 0, along_y = 0;
        bool all_one = true;
        for (int i = 0; i < strata; ++i) {
            const float u = (static_cast<float>(i) + 0.5f) / strata;
            along_x += static_cast<double>(filter.sample(u, 0.5f).weight);
            along_y += static_cast<double>(filter.sample(0.5f, u).weight);
            all_one = all_one && filter.sample(u, 1 - u).weight == 1.0f;
        }
        // The weight is a product, so its mean over the square is the product of the means. Each of at most 8 zeros of
        // the kernel misplaces at most one stratum of weight 2 c < 4, and the table stores fractions as float (6e-8).
        const double center = static_cast<double>(filter.sample(0.5f, 0.5f).weight);
        CHECK(along_x / strata * (along_y / strata) / center == Approx(1).margin(2 * 8 * 4.0 / strata));
        CHECK(all_one == !filter.has_negative_lobes());
    }
}

TEST_CASE("samples follow |kernel| and carry its sign", "[pixel_filter]") {
    constexpr int bins = 100, samples = 1 << 20;
    for (const auto& entry : kernels()) {
        const auto& name = entry.first;
        const Kernel& kernel = entry.second;
        CAPTURE(name);
        const PixelFilter filter = *make_pixel_filter(name, {});
        Random random(42);
        std::array<int, bins> count_x{}, count_y{};
        int wrong_sign = 0, outside = 0;
        for (int i = 0; i < samples; ++i) {
            const FilterSample s = filter.sample(random.uniform_float(), random.uniform_float());
            const double x = static_cast<double>(s.dx), y = static_cast<double>(s.dy);
            outside += std::abs(x) > kernel.radius || std::abs(y) > kernel.radius;
            const auto bin = [&](double v) {
                return static_cast<std::size_t>(std::min(bins - 1.0, (v / kernel.radius + 1) / 2 * bins));
            };
            ++count_x[bin(x)];
            ++count_y[bin(y)];
            wrong_sign += (kernel.value(x) * kernel.value(y) < 0) != (s.weight < 0);
        }
        CHECK(outside == 0);
        const auto absolute = [&](double x) { return std::abs(kernel.value(x)); };
        const double total = integrate(absolute, -kernel.radius, kernel.radius, 200'000);
        double chi_x = 0, chi_y = 0;
        for (std::size_t b = 0; b < bins; ++b) {
            const double from = kernel.radius * (2.0 * static_cast<double>(b) / bins - 1);
            const double expected = samples * integrate(absolute, from, from + 2 * kernel.radius / bins, 2000) / total;
            const auto term = [&](int count) { return (count - expected) * (count - expected) / expected; };
            chi_x += term(count_x[b]);
            chi_y += term(count_y[b]);
        }
        // z = 3.7: without the fixed seed there would be a false alarm in 1 of 10^4 runs per axis.
        CHECK(chi_x < test::chi_square_quantile(bins - 1, 3.7));
        CHECK(chi_y < test::chi_square_quantile(bins - 1, 3.7));
        // At zeros of the kernel the linear pieces can differ in sign from the curve within one piece (radius / 1024 or
        // less, with small |f|): a fraction of samples below 1e-4.
        CHECK(wrong_sign < samples / 10'000);
    }
}

TEST_CASE("sampling is monotone, so that stratification is preserved", "[pixel_filter]") {
    for (const auto& [name, kernel] : kernels()) {
        CAPTURE(name);
        const PixelFilter filter = *make_pixel_filter(name, {});
        float last = -filter.radius_x();
        int falls = 0;
        for (int i = 0; i < 100'000; ++i) {
            const float x = filter.sample(static_cast<float>(i) / 100'000, 0.25f).dx;
            // Float rounding of the start of a piece can step back by an ulp of the radius.
            falls += x < last - 5e-7f;
            last = x;
        }
        CHECK(falls == 0);
        const float end = filter.sample(1 - 0x1p-24f, 0).dx;
        CHECK(end <= filter.radius_x());
        CHECK(filter.sample(0, 0).dx >= -filter.radius_x());
    }
}

ParameterSet reals(const std::vector<std::pair<std::string, double>>& values) {
    ParameterSet set;
    for (const auto& [name, value] : values) {
        Parameter parameter;
        parameter.name = name;
        parameter.numbers = {value};
        set.parameters.push_back(parameter);
    }
    return set;
}

TEST_CASE("parameters have pbrt's names, and bad ones are errors", "[pixel_filter][law7]") {
    const Result<PixelFilter> wide = make_pixel_filter("gaussian", reals({{"xradius", 3}}));
    REQUIRE(wide);
    CHECK(wide->radius_x() == 3.0f);
    CHECK(wide->radius_y() == 1.5f);
    CHECK_FALSE(make_pixel_filter("gaussian", reals({{"xradius", -1}})));
    // This kernel nearly cancels, so its weights would be unbounded.
    CHECK_FALSE(make_pixel_filter("mitchell", reals({{"B", 0}, {"C", 1000}})));
    const Result<PixelFilter> unknown = make_pixel_filter("gauss", {});
    REQUIRE_FALSE(unknown);
    CHECK(unknown.error().message.find("expected one of: box") != std::string::npos);
}

}  // namespace
}  // namespace raylex::display
