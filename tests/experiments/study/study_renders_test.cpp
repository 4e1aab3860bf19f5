// The statistics of studies on real renders: properties of paths that simulations do not show. It takes a minute or
// two, so it runs only on request.
#include <catch2/catch.hpp>

#include <cstdio>

#include "display/output/metrics/error_metrics.h"
#include "experiments/study/analysis/bias.h"
#include "experiments/study/analysis/intervals.h"
#include "experiments/study/metrics.h"
#include "support/paths.h"
#include "transport/import/pbrt/pbrt_importer.h"
#include "transport/render/render.h"

using namespace raylex::experiments;
namespace display = raylex::display;
namespace transport = raylex::transport;

namespace {

constexpr int width = 24, height = 16;

PixelArray rendered(const transport::SceneDescription& scene, std::uint64_t samples, std::uint64_t seed) {
    transport::RenderSettings settings;
    settings.samples.per_pixel = samples;
    settings.samples.seed = seed;
    settings.film.resolution = {width, height};
    auto output = transport::render(scene, settings);
    REQUIRE(output);
    return {height, width, 3, output->frame_buffer.resolve(output->beauty, {0, 0, width, height})};
}

struct Coverage {
    int covered = 0, checked = 0, heavy = 0;
};

/// 200 sets of `replicates` renders each. The truth is the mean error of all of them: its own error, 1/14 of a set's,
/// widens no interval by more than 0.3 %.
Coverage measure(const std::string& name, std::uint64_t samples, std::size_t replicates) {
    constexpr std::size_t sets = 200;
    const auto scene =
        transport::import_pbrt(raylex::test::source_dir() + "/experiments/scenes/" + name + "/scene.pbrt");
    REQUIRE(scene);
    const PixelArray reference = rendered(*scene, 16384, 1'000'000);
    std::vector<std::vector<double>> errors(sets);
    std::vector<bool> heavy(sets);
    double truth = 0;
    for (std::size_t set = 0; set < sets; ++set) {
        TailMonitor tail;
        for (std::size_t i = 0; i < replicates; ++i) {
            const PixelArray image = rendered(*scene, samples, set * replicates + i);
            tail.add(display::relative_squares(image.values, reference.values));
            errors[set].push_back(measure_errors(image, reference)[display::ErrorMetric::relmse_mean]);
            truth += errors[set].back() / static_cast<double>(sets * replicates);
        }
        heavy[set] = tail.heavy();
    }
    Coverage result;
    for (std::size_t set = 0; set < sets; ++set) {
        result.heavy += heavy[set];
        if (heavy[set]) continue;
        const Interval interval = mean_interval(errors[set]);
        result.covered += interval.low <= truth && truth <= interval.high;
        ++result.checked;
    }
    std::printf(
        "%s, %zu sets of %zu renders: %d intervals of %d valid ones contain the truth, %d said to have a heavy tail\n",
        name.c_str(), sets, replicates, result.covered, result.checked, result.heavy);
    return result;
}

}  // namespace

TEST_CASE("95 % intervals cover the errors of real renders", "[.full][study][statistical]") {
    // 200 sets: one binomial standard error is 1.5 %. 91 % is below 95 % by 2.6 of them.
    const Coverage room = measure("cornell-color", 16, 8);
    CHECK(room.heavy <= 10);  // diffuse surfaces under a light with light sampling
    CHECK(room.covered >= 0.91 * room.checked);
    // Caustics of glass: intervals cover in two of three sets, so nearly all sets must have the note that theirs is not
    // valid.
    const Coverage glass = measure("still-life", 16, 8);
    CHECK(glass.heavy >= 180);
}

TEST_CASE("the bias test of real renders against renders of the same method keeps its level",
          "[.full][study][statistical]") {
    const auto scene =
        transport::import_pbrt(raylex::test::source_dir() + "/experiments/scenes/cornell-color/scene.pbrt");
    REQUIRE(scene);
    int alarms = 0;
    for (std::uint64_t k = 0; k < 100; ++k) {
        BiasSide method, other;
        for (std::uint64_t i = 0; i < 8; ++i) {
            method.replicates.push_back(block_means(rendered(*scene, 16, 10'000 + k * 16 + i)));
            other.replicates.push_back(block_means(rendered(*scene, 16, 10'008 + k * 16 + i)));
        }
        BiasOptions options;
        options.level = 0.05;
        alarms += test_bias(method, other, options).differs;
    }
    std::printf("bias test of a method against itself, level 5 %%: %d alarms in 100\n", alarms);
    CHECK(alarms <= 11);  // 5, plus three binomial standard errors of 2.2
}
