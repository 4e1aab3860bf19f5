// Guided paths against plain ones on whole scenes: the image and its blocks have the same means in each colour. The
// comparison states the bias that it would detect, and checks it.
#include <cstdlib>
#include <filesystem>
#include <iostream>

#include "tests/support/paths.h"
#include "tests/support/skip.h"
#include "transport/guide/guide_support.h"
#include "transport/import/pbrt/pbrt_importer.h"

using namespace render_test;
namespace fs = std::filesystem;

namespace {

/// A scene and the samples per pixel of its 64 renders of each kind.
struct ComparedScene {
    const char* name;
    std::uint64_t samples;
    int training;  ///< samples for the training of each guided render
    bool guided;   ///< false: paths of the scene find too little to guide, or end at their first surface
    double bias;   ///< the largest bias of the image that may stay undetected, relative to its mean
};

// In experiments/scenes. Smaller images teach less, so scenes with few guided surfaces train longer.
const std::vector<ComparedScene> quiet_scenes{
    {"point-plane", 16, 16, false, 0.005},
    {"furnace-sphere", 16, 16, false, 0.005},
    {"furnace-box", 16, 16, false, 0.005},
    {"cornell-grey", 64, 16, true, 0.005},
};
const std::vector<ComparedScene> noisy_scenes{
    {"cornell-color", 64, 16, true, 0.005}, {"cornell-fog", 1280, 16, true, 0.005},
    {"mis-plates", 2560, 16, true, 0.007},  // sharp reflections of small bright lamps; 0.5 % takes 7 CPU minutes
    {"still-life", 512, 512, true, 0.005},  {"sky-image", 512, 512, true, 0.005},
};
// Beside the project.
const std::vector<ComparedScene> other_scenes{
    {"displaced-sphere-1m", 16, 16, false, 0.005},
    {"bitterli-cornell-box", 128, 16, true, 0.005},
    {"bitterli-veach-mis", 2560, 16, true, 0.007},     // as mis-plates
    {"bitterli-veach-bidir", 2560, 16, true, 0.0135},  // caustics of lamps in glass; 0.5 % takes 35 CPU minutes
};

/// Compares blocks and whole images, each family of tests of all scenes at a level of one in a thousand (Sidak). The
/// degrees of freedom are those of one side, with which Welch's t has no more false alarms than the level.
void check_scene(const ComparedScene& each, const fs::path& folder) {
    constexpr int seeds = 64;
    constexpr std::size_t blocks = blocks_across * blocks_across;
    constexpr double rounding = 1e-5;  // products of a few dozen floats, for means without noise
    const std::size_t tests = 3 * (quiet_scenes.size() + noisy_scenes.size() + other_scenes.size());
    const double limit = student_threshold(seeds - 1, tests),
                 limit_of_blocks = student_threshold(seeds - 1, tests * blocks);
    auto scene = transport::import_pbrt((folder / each.name / "scene.pbrt").string());
    INFO(each.name << ": " << (scene ? std::string() : scene.error().to_string()));
    REQUIRE(scene.ok());
    const auto built = transport::BuiltScene::build(*std::move(scene));
    REQUIRE(built.ok());
    transport::RenderSettings settings;
    settings.film.resolution = {33, 24};  // blocks of 11 x 8 pixels
    settings.samples.per_pixel = each.samples;
    settings.machine.threads = 2;
    settings.paths.integrator = integrator_named("path");
    Replicates plain = replicates(**built, settings, 1, seeds, 1, -1);
    settings.paths.integrator = with_guide(integrator_named("path"), "on", each.training);
    Replicates guided = replicates(**built, settings, 1, seeds, 1'001, -1);
    settings.samples.per_pixel = 1;
    const auto one = transport::render(**built, settings);
    REQUIRE(one.ok());
    CHECK(one->statistics.guide.used == each.guided);
    double worst = 0, detected = 0;
    for (std::size_t color = 0; color < 3; ++color) {
        const Estimate a = plain.channel(color), b = guided.channel(color);
        const double error = std::hypot(a.error, b.error);
        CAPTURE(color, a.mean, a.error, b.mean, b.error, limit);
        CHECK(a.mean > 0);
        CHECK(std::abs(a.mean - b.mean) <= limit * error + rounding * a.mean);
        worst = std::max(worst, std::abs(a.mean - b.mean) / (error + rounding * a.mean));
        // Nine in ten: a bias of this size moves t to 1.2816 beyond the limit.
        detected = std::max(detected, (limit + 1.2816) * error / a.mean);
    }
    pool_rare_blocks(plain, guided);
    double worst_block = 0;
    for (std::size_t i = 0; i < 3 * blocks; ++i) {
        const double error = std::sqrt(plain.variance(i) + guided.variance(i)) + rounding * plain.mean(i);
        CAPTURE(i / blocks, i % blocks, plain.mean(i), guided.mean(i), error, limit_of_blocks);
        CHECK(std::abs(plain.mean(i) - guided.mean(i)) <= limit_of_blocks * error);
        if (error > 0) worst_block = std::max(worst_block, std::abs(plain.mean(i) - guided.mean(i)) / error);
    }
    std::cout << each.name << ": t " << worst << " of at most " << limit << ", of blocks " << worst_block
              << " of at most " << limit_of_blocks << "; detects a bias of " << 100 * detected << " %" << std::endl;
    CHECK(detected <= each.bias);
}

fs::path scenes_of_project() {
    return fs::path(raylex::test::source_dir()) / "experiments" / "scenes";
}

}  // namespace

TEST_CASE("guided paths have the means of plain ones on quiet scenes", "[guide][render][gate][statistical]") {
    for (const ComparedScene& each : quiet_scenes) check_scene(each, scenes_of_project());
}

TEST_CASE("guided paths have the means of plain ones on noisy scenes", "[guide][render][.full][statistical]") {
    for (const ComparedScene& each : noisy_scenes) check_scene(each, scenes_of_project());
}

TEST_CASE("guided paths have the means of plain ones on scenes beside the project",
          "[guide][render][.full][statistical]") {
    const char* const given = std::getenv("RAYLEX_REFERENCES");
    const fs::path folder =
        given != nullptr ? fs::path(given) : fs::path(raylex::test::source_dir()) / ".." / "shared" / "data" / "scenes";
    if (!fs::exists(folder)) RAYLEX_SKIP("no shared scenes; set RAYLEX_REFERENCES to their folder");
    for (const ComparedScene& each : other_scenes) check_scene(each, folder);
}
