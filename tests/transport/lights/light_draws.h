// Draws from lights of small scenes, and checks of their densities.
#pragma once

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "tests/transport/lit_scene.h"
#include "transport/math/sampling.h"
#include "transport/samplers/pixel_sampler.h"

namespace image_lights {

using namespace raylex;
using namespace raylex::transport;

inline constexpr double pi_d = std::numbers::pi;

inline PixelSampler numbers(std::uint64_t i) {
    return PixelSampler(SamplerKind::sobol, 7, 0, 0, i);
}

inline bool draw(const Lit& scene, const Vec3& from, std::uint64_t i, LightSample& s) {
    const PixelSampler sampler = numbers(i);
    return scene.lights.sample(scene.lights.chooser(LightChoice::mis), scene.geometry, from, sampler.get_1d(1),
                               sampler.get_2d(2), s);
}

inline bool emit(const Lit& scene, std::uint64_t i, EmissionSample& s) {
    const PixelSampler sampler = numbers(i);
    return scene.lights.sample_emission(scene.lights.chooser(LightChoice::light_sampling), scene.geometry,
                                        sampler.get_1d(1), sampler.get_2d(2), sampler.get_2d(3), s);
}

/// The density per steradian of light that the only light emits.
inline double density_of_direction(const Lit& scene, const Vec3& d) {
    return static_cast<double>(
        scene.lights
            .emission_density(scene.lights.chooser(LightChoice::light_sampling), scene.geometry, LightSample(), d)
            .direction);
}

struct Mean {
    double value = 0, error = 0;
};

/// The mean of `count` values, and a standard error as if they were independent, which overestimates for Sobol' points.
inline Mean mean_of(int count, const std::function<double(std::uint64_t)>& value) {
    double sum = 0, squares = 0;
    for (int i = 0; i < count; ++i) {
        const double v = value(static_cast<std::uint64_t>(i));
        sum += v;
        squares += v * v;
    }
    const double mean = sum / count;
    return {mean, std::sqrt(std::max(0.0, squares / count - mean * mean) / count)};
}

/// Irradiance (green) at `p` on a plane with normal `n`, unoccluded.
inline Mean irradiance(const Lit& scene, const Vec3& p, const Vec3& n, int count = 1 << 14) {
    return mean_of(count, [&](std::uint64_t i) {
        LightSample s;
        if (!draw(scene, p, i, s)) return 0.0;
        return std::max(
            0.0, static_cast<double>(dot(n, s.wi)) * static_cast<double>(s.radiance.g) / static_cast<double>(s.pdf));
    });
}

/// Chi-squared statistic of samples over n x n cells of equal solid angle, against the integral of `density` over the
/// cells. Cells with an expectation below 8 are merged.
inline void check_directions(const std::function<bool(std::uint64_t, Vec3&)>& sample,
                             const std::function<double(const Vec3&)>& density) {
    constexpr int n = 12, looks = 24, count = 40000;
    std::vector<double> found(n * n, 0), expected(n * n, 0);
    double whole = 0;
    for (int y = 0; y < n * looks; ++y)
        for (int x = 0; x < n * looks; ++x) {
            const Vec2 at{(static_cast<Real>(x) + 0.5f) / (n * looks), (static_cast<Real>(y) + 0.5f) / (n * looks)};
            const double share = density(direction_from_octahedral(at)) * 4 * pi_d / (n * looks * n * looks);
            expected[static_cast<std::size_t>(y / looks * n + x / looks)] += count * share;
            whole += share;
        }
    int drawn = 0;
    for (std::uint64_t i = 0; i < count; ++i) {
        Vec3 d;
        if (!sample(i, d)) continue;
        ++drawn;
        const Vec2 at = octahedral_from_direction(d);
        const int x = std::min(static_cast<int>(at.x * n), n - 1), y = std::min(static_cast<int>(at.y * n), n - 1);
        ++found[static_cast<std::size_t>(y * n + x)];
    }
    // The midpoint rule of 24 x 24 points a cell misses edges of the density by about half a point's width.
    CHECK(whole == Approx(static_cast<double>(drawn) / count).margin(0.02));
    double chi2 = 0, rest_found = 0, rest_expected = 0;
    int cells = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
        if (expected[i] < 8) {
            rest_found += found[i];
            rest_expected += expected[i];
            continue;
        }
        // The quadrature error of 2 % of a cell is added to the variance.
        chi2 += (found[i] - expected[i]) * (found[i] - expected[i]) /
                (expected[i] + 0.02 * 0.02 * expected[i] * expected[i]);
        ++cells;
    }
    CAPTURE(chi2, cells, rest_found, rest_expected);
    CHECK(cells >= 4);
    // With k degrees of freedom: mean k, variance 2 k; 5 standard deviations.
    CHECK(chi2 < cells + 5 * std::sqrt(2.0 * cells));
    CHECK(std::abs(rest_found - rest_expected) < 5 * std::sqrt(rest_expected + 1) + 0.02 * count * 0.1);
}

inline const std::string sphere_in_the_middle = "\nShape \"sphere\" \"float radius\" 0.5\n";

}  // namespace image_lights
