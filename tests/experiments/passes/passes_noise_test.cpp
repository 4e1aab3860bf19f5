// Noise of passes: statistics, adaptive sampling and interrupts; what pilots measure; and, on request, that pruned
// passes have the light of unpruned renders.
#include <catch2/catch.hpp>

#include <atomic>
#include <bit>
#include <cmath>
#include <random>

#include "experiments/propose/pilot.h"
#include "experiments/study/analysis/distributions.h"
#include "passes_support.h"
#include "tests/transport/enclosure.h"

using namespace passes_test;

namespace {

double sum_of(const std::vector<double>& values) {
    double sum = 0;
    for (const double value : values) sum += value;
    return sum;
}

/// 43 expressions that partition all paths by their first two scatterings.
std::vector<std::string> classes_of_two_scatterings() {
    const std::vector<std::string> events{"<RD>", "<RG>", "<RS>", "<TS>", "<T[^S]>", "V"};
    std::vector<std::string> classes{"C[LOB]"};
    for (const std::string& first : events) {
        classes.push_back("C" + first + "[LOB]");
        for (const std::string& second : events) classes.push_back("C" + first + second + ".*");
    }
    return classes;
}

/// The p-value of Welch's test that two means are equal, and 1 where both are certain and equal.
double welch_p(const Replicates& a, const Replicates& b, std::size_t i) {
    const double va = a.variance(i), vb = b.variance(i), difference = a.mean(i) - b.mean(i);
    if (va + vb == 0) return difference == 0 ? 1 : 0;
    const double degrees =
        (va + vb) * (va + vb) /
        (va * va / static_cast<double>(a.of_seed.size() - 1) + vb * vb / static_cast<double>(b.of_seed.size() - 1));
    return student_t_two_sided(difference / std::sqrt(va + vb), degrees);
}

}  // namespace

TEST_CASE("Passes: the variance of light that lands on any pixel is that between seeds",
          "[passes][statistical][gate]") {
    const std::string passes = pass("path", "rest", "spp = 4\n") + pass("lighttracer", "C<RD>L", "spp = 64\n");
    const std::string statistics = "[channels.statistics]\npass_lighttracer = ['mse', 'even', 'odd']\n";
    const std::string scene = ball_scene(area_light), layers = "[render]\nlayer_passes = true\n";
    PlannedJob plan = plan_of(scene, layers + statistics + passes), plain = plan_of(scene, layers + passes);
    constexpr int seeds = 24;
    Replicates images;
    double stated = 0, worst = 0;
    for (int seed = 0; seed < seeds; ++seed) {
        plan.job.settings.samples.seed = plain.job.settings.samples.seed = static_cast<std::uint64_t>(seed);
        const JobOutput rendered = plan.rendered();
        images.of_seed.push_back(values_of(rendered, "pass_lighttracer"));
        stated += sum_of(values_of(rendered, "pass_lighttracer_mse")) / seeds;
        const std::vector<double> even = values_of(rendered, "pass_lighttracer_even"),
                                  odd = values_of(rendered, "pass_lighttracer_odd");
        for (std::size_t i = 0; i < even.size(); ++i)
            worst = std::max(worst, std::abs((even[i] + odd[i]) / 2 - images.of_seed.back()[i]));
        if (seed > 0) continue;
        // Law 2: statistics change no bit of the image.
        const std::vector<double> a = values_of(rendered, "beauty"), b = values_of(plain.rendered(), "beauty");
        for (std::size_t i = 0; i < a.size(); ++i)
            CHECK(std::bit_cast<std::uint64_t>(a[i]) == std::bit_cast<std::uint64_t>(b[i]));
    }
    CHECK(worst < 1e-12);
    // The variance of a pixel's mean between 24 seeds is uncertain by sqrt(2 / 23); the sum over 324 pixels with light
    // of different strength by 0.05 at most, and so is the stated one. 0.2 is four times that.
    const double between = images.sum_of_variances() * seeds;
    INFO(stated << " stated, " << between << " between seeds");
    CHECK(std::abs(stated / between - 1) < 0.2);
}

TEST_CASE("Passes: adaptive sampling within passes whose samples belong to pixels", "[passes]") {
    const PlannedJob plan =
        plan_of(ball_scene(area_light), "[render]\nspp = 4096\n[adaptive]\nerror = '10%'\nmin_samples = 16\n" +
                                            pass("path", "C<RD>L") + pass("bdpt", "rest", "spp = 8\n"));
    const JobOutput rendered = plan.rendered();
    REQUIRE(rendered.passes.size() == 2);
    CHECK(rendered.passes[0].samples_per_pixel >= 16);
    CHECK(rendered.passes[0].samples_per_pixel < 4096);
    CHECK(rendered.passes[1].samples_per_pixel == 8);  // its light lands on any pixel
    REQUIRE(rendered.output.samples.adaptive);
    CHECK(rendered.output.samples.adaptive->error <= 0.1);
}

TEST_CASE("Passes: an interrupted pass records the samples that it finished", "[passes]") {
    const PlannedJob plan =
        plan_of(ball_scene(area_light), "[render]\nspp = 1000000\n" + pass("path", "C<RD>.*") + pass("bdpt", "rest"));
    std::atomic<bool> stop{false};
    const auto stop_early = [&](const transport::RenderProgress& now) { stop = now.samples_done > 0; };
    const auto rendered = render_job(plan.job, plan.passes, plan.loaded->scene, *plan.built, stop_early, &stop);
    REQUIRE(rendered.ok());
    CHECK_FALSE(rendered->output.samples.complete);
    CHECK(rendered->passes[0].samples_per_pixel > 0);
    CHECK(rendered->passes[0].samples_per_pixel < 1000000);
    CHECK(rendered->passes[0].text.find("INCOMPLETE") != std::string::npos);
    CHECK(rendered->passes[1].text == "bdpt: not rendered");
}

TEST_CASE("Passes: pilots measure the noise of a sample, whatever their number", "[passes][statistical][gate]") {
    const PlannedJob plan = plan_of(ball_scene(area_light), "");
    const std::vector<std::string> classes{"C<RD>L", "(.*)-(C<RD>L)"};
    std::vector<double> noise[2];
    for (const std::uint64_t samples : {4, 64}) {
        Pilot pilot(plan.job, *plan.built, {18, 18}, {.longer_side = 64, .samples = samples, .seeds = 16, .seed = 0});
        const auto measured = pilot.measure(integrator_named("path"), classes, true);
        REQUIRE(measured.ok());
        std::vector<double>& found = noise[samples == 4 ? 0 : 1];
        for (const PilotNoise& each : measured->of_class) found.push_back(each.squared);
        const std::vector<const PilotPass*> twice{&*measured, &*measured};
        // The same pass twice, each with four samples: the deviation of half of each is that of one.
        CHECK(pilot.noise_of(twice, {4, 4}).squared == Approx(measured->whole.squared).epsilon(1e-9));
        const auto pruned = pilot.measure(integrator_named("path"), {classes[0]}, false);
        REQUIRE(pruned.ok());
        // direct light: its noise does not depend on pruning; 16 seeds of 324 pixels give it to within 4 %
        CHECK(std::abs(pruned->whole.squared / found[0] - 1) < 0.15);
    }
    // Samples are independent here. The largest 0.1 % of errors, which are left out, have a tail at 4 samples and
    // hardly one at 64.
    CHECK(std::abs(noise[0][0] / noise[1][0] - 1) < 0.15);
    CHECK(noise[0][1] > 0);
}

TEST_CASE("Passes: pruned passes have the light of unpruned renders", "[passes][statistical][.full]") {
    constexpr int seeds = 12, partitions = 20;
    constexpr std::size_t blocks = blocks_across * blocks_across;
    const std::string method = GENERATE("path", "bdpt", "lighttracer");
    const std::vector<std::string> scenes{enclosure(0.45, 0.35, 100), ball_scene(area_light), ball_scene(point_light),
                                          many_lights(), foggy_room()};
    const std::vector<std::string> items = classes_of_two_scatterings();
    std::mt19937 random(46);
    double least = 1, tests = 0;
    std::string where;
    for (std::size_t s = 0; s < scenes.size(); ++s) {
        const PlannedJob plan = plan_of(scenes[s], "");
        transport::RenderSettings settings;
        settings.samples.per_pixel = 64;
        settings.paths.max_depth = 6;
        settings.paths.integrator = integrator_named(method);
        std::vector<std::string> classes;
        for (int partition = 0; partition < partitions; ++partition) {
            std::string sides[2];
            for (const std::string& item : items) {
                std::string& side = sides[random() % 2];
                side += (side.empty() ? "(" : "|(") + item + ")";
            }
            classes.insert(classes.end(), {sides[0], sides[1]});
        }
        transport::RenderSettings all = settings;
        for (const std::string& each : classes)
            all.channels.list.push_back(lpe_channel("c" + std::to_string(all.channels.list.size()), each));
        const Replicates unpruned = replicates(*plan.built, all, 1 + static_cast<int>(classes.size()), seeds, 1);
        for (std::size_t i = 0; i < classes.size(); ++i) {
            settings.channels.takes = classes[i];
            Replicates pruned = replicates(*plan.built, settings, 1, seeds, 1000 * (i + 1)), same;
            for (const std::vector<double>& each : unpruned.of_seed) {
                const auto first = each.begin() + static_cast<std::ptrdiff_t>((i + 1) * blocks);
                same.of_seed.emplace_back(first, first + static_cast<std::ptrdiff_t>(blocks));
            }
            pool_rare_blocks(same, pruned);
            for (std::size_t b = 0; b < blocks; ++b) {
                const double p = welch_p(same, pruned, b);
                ++tests;
                if (p >= least) continue;
                least = p;
                where = "scene " + std::to_string(s) + ", " + classes[i] + ", block " + std::to_string(b);
            }
        }
    }
    INFO(method << ": p = " << least << " of " << tests << " tests, " << where);
    CHECK(sidak_adjusted(least, tests) > 0.001);
}
