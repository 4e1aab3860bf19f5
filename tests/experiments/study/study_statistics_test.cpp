// The statistics of studies on simulations with known results. All seeds are fixed, so these tests either always pass
// or always fail; the bounds are binomial standard errors of the stated number of repetitions.
#include <catch2/catch.hpp>

#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "experiments/study/analysis/bias.h"
#include "experiments/study/analysis/convergence.h"
#include "experiments/study/analysis/distributions.h"
#include "experiments/study/analysis/intervals.h"
#include "experiments/study/analysis/pareto.h"
#include "experiments/study/analysis/spectrum.h"

using namespace raylex::experiments;

namespace {

using Random = std::mt19937_64;

// 1,000 repetitions at 95 %: one binomial standard error is 0.69 %, so 93 to 97 % is within 2.9 of them.
constexpr int repetitions = 1000;
void check_coverage(int covered) {
    CAPTURE(covered);
    CHECK(covered >= 930);
    CHECK(covered <= 970);
}

/// Returns a replicate's mean squared error: the mean of 40 squared normals of mean `truth`, with a coefficient of
/// variation of 22 %, like an image in which forty pixels dominate.
double simulated_error(Random& random, double truth) {
    std::gamma_distribution<double> gamma(20, truth / 20);
    return gamma(random);
}

bool contains(const Interval& interval, double truth) {
    return interval.low <= truth && truth <= interval.high;
}

}  // namespace

TEST_CASE("quantiles agree with tables", "[study]") {
    CHECK(student_t_quantile(0.975, 7) == Approx(2.364624).epsilon(1e-6));
    CHECK(student_t_quantile(0.975, 1) == Approx(12.7062).epsilon(1e-5));
    CHECK(student_t_quantile(0.975, 1e12) == Approx(1.959964).epsilon(1e-6));
    CHECK(student_t_two_sided(2.364624, 7) == Approx(0.05).epsilon(1e-5));
    CHECK(detectable_shift(0.05, 0.9, 1e12) == Approx(1.959964 + 1.281552).epsilon(1e-6));
    // n = 10 in one sample at 5 % and 80 %: a shift of 0.996 standard deviations (G*Power, two-sided one-sample t).
    CHECK(detectable_shift(0.05, 0.8, 9) / std::sqrt(10.0) == Approx(0.996).epsilon(2e-3));
    // One degree of freedom, critical value 2 / (pi alpha): the two methods agree up to the 1 / critical that one of
    // them neglects.
    const double pi = std::acos(-1.0);
    const auto per_critical = [&](double critical) { return detectable_shift(2 / (pi * critical), 0.9, 1) / critical; };
    CHECK(per_critical(1010) == Approx(per_critical(990)).epsilon(2e-3));
    CHECK(per_critical(1e8) == Approx(per_critical(1010)).epsilon(2e-3));
    CHECK(sidak_level(0.05, 10) == Approx(0.0051162).epsilon(1e-4));
    CHECK(sidak_adjusted(sidak_level(0.01, 345), 345) == Approx(0.01).epsilon(1e-9));
}

TEST_CASE("95 % intervals of errors cover, by t and by bootstrap", "[study][statistical]") {
    const double truth = 0.02;
    for (const std::size_t n : {4, 8, 16, 40}) {
        CAPTURE(n);
        Random random(1000 + n);
        int covered = 0;
        IntervalOptions options;
        options.resamples = 399;
        for (int k = 0; k < repetitions; ++k) {
            std::vector<double> errors(n);
            for (double& error : errors) error = simulated_error(random, truth);
            options.seed = static_cast<std::uint64_t>(k);
            const Interval interval = mean_interval(errors, options);
            REQUIRE(interval.valid());
            REQUIRE(interval.how.starts_with(n < 32 ? "t, " : "bootstrap"));
            covered += contains(interval, truth);
        }
        check_coverage(covered);
    }
}

TEST_CASE("the reference's noise is subtracted from the measured error", "[study][statistical]") {
    const double truth = 0.01, excess = 0.004;
    Random random(5);
    int covered = 0;
    for (int k = 0; k < repetitions; ++k) {
        std::vector<double> measured(8);
        for (double& error : measured) error = simulated_error(random, truth + excess);
        covered += contains(error_interval(measured, excess), truth);
    }
    check_coverage(covered);
    const std::vector<double> near{0.0041, 0.0042, 0.0040};
    CHECK(error_interval(near, excess).note == "at the reference's own error");
}

TEST_CASE("speed-ups cover when errors and times vary together", "[study][statistical]") {
    // B is 2.5 times as efficient. Within a replicate a slow run is also more accurate, so a ratio without the
    // covariance would be too wide, and one by geometric means would be wrong.
    Random random(77);
    std::normal_distribution<double> normal;
    int covered = 0;
    for (int k = 0; k < repetitions; ++k) {
        std::vector<double> ea, ta, eb, tb;
        for (int i = 0; i < 8; ++i) {
            const double slow_a = std::exp(0.1 * normal(random)), slow_b = std::exp(0.1 * normal(random));
            ea.push_back(simulated_error(random, 0.05) / slow_a);
            ta.push_back(slow_a);
            eb.push_back(simulated_error(random, 0.01) / slow_b);
            tb.push_back(2 * slow_b);
        }
        // E[mean(1/slow)] E[mean(slow)] is the same factor on both sides and cancels.
        covered += contains(speed_up_interval({eb, tb}, {ea, ta}), 2.5);
    }
    check_coverage(covered);
    const std::vector<double> one{0.1};
    CHECK(efficiency_interval(one, one).note == "one replicate");
    CHECK(efficiency_interval(one, one).value == Approx(100));
}

TEST_CASE("slopes cover, and a shallow one is flagged where -1 is excluded", "[study][statistical]") {
    Random random(99);
    int covered = 0, accused = 0, caught = 0;
    for (int k = 0; k < repetitions; ++k) {
        std::vector<BudgetGroup> unbiased, flattening;
        for (double budget = 16; budget <= 1024; budget *= 2) {
            BudgetGroup group, flat;
            group.budget = flat.budget = budget;
            for (int i = 0; i < 6; ++i) {
                group.errors.push_back(simulated_error(random, 1 / budget));
                flat.errors.push_back(simulated_error(random, 1 / budget + 0.002));
                for (BudgetGroup* each : {&group, &flat}) {
                    each->samples.push_back(budget);
                    each->seconds.push_back(budget * 0.01 + 0.5);
                    each->setup_seconds = 0.5;
                }
            }
            unbiased.push_back(group);
            flattening.push_back(flat);
        }
        const std::optional<Line> line = fit_line(unbiased, Against::samples);
        REQUIRE(line);
        REQUIRE(line->least_x == Approx(std::log(64)));  // four octaves below 1024
        covered += line->slope_low <= -1 && -1 <= line->slope_high;
        accused += test_slope(unbiased, true).too_shallow;
        caught += test_slope(flattening, true).too_shallow;
    }
    check_coverage(covered);
    CHECK(accused <= 40);  // 2.5 % on the shallow side, 25, plus three standard errors
    CHECK(caught >= 970);  // the last two octaves must show it alone
}

TEST_CASE("a method with a start-up is not reported as biased", "[study][statistical]") {
    // Slopes of -0.14 to -0.91 that approach -1, like a chain that warms up over a hundred samples.
    Random random(41);
    int accused = 0, starting = 0;
    for (int k = 0; k < repetitions; ++k) {
        std::vector<BudgetGroup> groups;
        for (double budget = 16; budget <= 1024; budget *= 2) {
            BudgetGroup group;
            group.budget = budget;
            for (int i = 0; i < 6; ++i) group.errors.push_back(simulated_error(random, 1 / (budget + 100)));
            group.samples.assign(6, budget);
            group.seconds.assign(6, budget);
            groups.push_back(group);
        }
        const SlopeTest result = test_slope(groups, true);
        accused += result.too_shallow;
        starting += result.nears;
        if (result.nears) CHECK(result.text.starts_with("not at -1 yet, but closer with every octave: from -0."));
    }
    CHECK(accused <= 40);    // 2.5 %, plus three standard errors
    CHECK(starting >= 950);  // of those with a slope visibly shallower than -1
}

TEST_CASE("with few budgets or replicates no method is too shallow", "[study]") {
    std::vector<BudgetGroup> groups;
    for (const double budget : {64.0, 256.0, 1024.0, 4096.0}) {
        BudgetGroup group;
        group.budget = budget;
        for (const double scatter : {0.99, 1.0, 1.01}) group.errors.push_back(scatter / std::sqrt(budget));
        group.samples.assign(3, budget);
        group.seconds.assign(3, budget);
        groups.push_back(group);
    }
    CHECK(test_slope(groups, true).too_shallow);
    groups.back().errors.pop_back();
    groups.back().samples.pop_back();
    CHECK_FALSE(test_slope(groups, true).too_shallow);
    groups.pop_back();
    CHECK_FALSE(test_slope(groups, true).too_shallow);
    CHECK(test_slope(groups, true).text.starts_with("shallower than -1; not judged: needs four budgets"));
}

TEST_CASE("a well-known slope is not called noisy, and no cause is claimed", "[study]") {
    const auto result_on = [](double early, double late, double scatter) {
        std::vector<BudgetGroup> groups;
        double error = 1;
        for (double budget = 16; budget <= 1024; budget *= 2) {
            BudgetGroup group;
            group.budget = budget;
            for (const double each : {1 - scatter, 1.0, 1 + scatter}) group.errors.push_back(each * error);
            group.samples.assign(3, budget);
            group.seconds.assign(3, budget);
            groups.push_back(group);
            error *= std::exp2(budget < 256 ? early : late);
        }
        return test_slope(groups, true);
    };
    const SlopeTest open = result_on(-0.955, -0.955, 0.03), near = result_on(-0.9, -0.97, 0.001);
    REQUIRE(open.checked()->slope_high < -0.9);  // well known, and not -1
    REQUIRE(open.checked()->slope_low > -0.98);
    CHECK_FALSE(open.too_shallow);
    CHECK(open.text.find("not certain for the last 2") != std::string::npos);
    for (const SlopeTest& each : {open, near}) {
        CAPTURE(each.text);
        CHECK(each.text.find("noisy") == std::string::npos);
        CHECK(each.text.find("start-up") == std::string::npos);
        CHECK(each.text.find(": from -0.") != std::string::npos);
    }
    CHECK(near.nears);
}

TEST_CASE("the time to an error covers inside and outside the measured range", "[study][statistical]") {
    // Relative error r at K / r^2 + setup with K = 0.01 and setup 2: 1 % at 102 s, 5 % at 6 s.
    Random random(123);
    int covered_inside = 0, covered_outside = 0, predicted = 0;
    for (int k = 0; k < repetitions; ++k) {
        std::vector<BudgetGroup> groups;
        for (double seconds = 1; seconds <= 16; seconds *= 2) {
            BudgetGroup group;
            group.budget = seconds;
            group.setup_seconds = 2;
            for (int i = 0; i < 6; ++i) {
                group.errors.push_back(simulated_error(random, 0.01 / seconds));
                group.seconds.push_back(seconds + 2);
            }
            groups.push_back(group);
        }
        const TimeToError inside = time_to_error(groups, 0.05), outside = time_to_error(groups, 0.01);
        REQUIRE_FALSE(inside.extrapolated);
        REQUIRE(outside.extrapolated);
        covered_inside += contains(inside.seconds, 6);
        covered_outside += contains(outside.seconds, 102);
        const auto check = check_prediction(groups);
        REQUIRE(check);
        REQUIRE(check->actual_seconds == Approx(18));
        predicted += std::abs(check->relative_difference()) < 0.25;
    }
    check_coverage(covered_inside);
    check_coverage(covered_outside);
    CHECK(predicted >= 900);
    std::vector<BudgetGroup> stuck(4);
    for (std::size_t i = 0; i < stuck.size(); ++i) {
        stuck[i].errors = {0.011, 0.009, 0.010};
        stuck[i].seconds.assign(3, std::exp2(static_cast<double>(i)));
    }
    CHECK(time_to_error(stuck, 0.01).seconds.note == "not reached: the error no longer falls");
}

TEST_CASE("a heavy tail is distinguished from pixels that are always hard", "[study][statistical]") {
    Random random(31);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform;
    int false_alarms = 0, found = 0;
    for (int k = 0; k < 200; ++k) {
        TailMonitor light, heavy;
        // Pixels whose variances spread over a factor of e^2 either way, equal in every replicate.
        std::vector<double> spread(4096);
        for (double& each : spread) each = std::exp(0.5 * normal(random));
        for (int replicate = 0; replicate < 4; ++replicate) {
            std::vector<double> a(4096), b(4096);
            for (std::size_t i = 0; i < a.size(); ++i) {
                const double z = normal(random);
                a[i] = spread[i] * z * z;
                b[i] = spread[i] * std::pow(1 - uniform(random), -1 / 0.9);  // Pareto with index 0.9, which has no mean
            }
            light.add(a);
            heavy.add(b);
        }
        false_alarms += light.heavy();
        found += heavy.heavy();
    }
    CHECK(false_alarms == 0);
    CHECK(found >= 190);
}

TEST_CASE("the bias test keeps its level and finds the stated detectable bias", "[study][statistical][gate]") {
    // 12 blocks and the whole image, eight replicates against a noisy reference.
    constexpr std::size_t blocks = 12, replicates = 8;
    const double mean = 2, sigma = 0.1, reference_sigma = 0.01;
    Random random(4711);
    std::normal_distribution<double> normal;
    const auto draw = [&](double center, double deviation) {
        std::vector<double> means(blocks + 1, 0.0);
        for (std::size_t b = 0; b < blocks; ++b) {
            means[b] = center + deviation * normal(random);
            means[blocks] += means[b] / blocks;
        }
        return means;
    };
    BiasOptions options;
    options.level = 0.05;
    // The smallest bias of the whole image that is found, from the true deviations.
    const double whole_error = std::sqrt((sigma * sigma / replicates + reference_sigma * reference_sigma) / blocks);
    const double b = reference_sigma * reference_sigma;
    const double level = options.level / 2;  // one whole image
    const double bias = detectable_shift(level, options.power, replicates - 1) * whole_error;
    int alarms = 0, found = 0;
    double stated = 0;
    for (int k = 0; k < repetitions; ++k) {
        BiasSide reference{{draw(mean, reference_sigma)}, std::vector<double>(blocks + 1, b)};
        reference.variance[blocks] = b / blocks;
        BiasSide clean, planted;
        for (std::size_t i = 0; i < replicates; ++i) {
            clean.replicates.push_back(draw(mean, sigma));
            planted.replicates.push_back(draw(mean + bias, sigma));
        }
        const BiasTest result = test_bias(clean, reference, options);
        alarms += result.differs;
        stated += result.detectable_whole / repetitions;
        found += test_bias(planted, reference, options).differs;
    }
    CAPTURE(alarms, found, stated, bias / mean);
    // 5 % of 1,000 is 50 with standard error 6.9; the bound is three standard errors above. The known variance of the
    // reference, and the whole image as the mean of the blocks, make the true level about half of that.
    CHECK(alarms <= 71);
    CHECK(alarms >= 5);
    CHECK(found >= 900);
    CHECK(stated ==
          Approx(bias / mean).epsilon(0.1));  // a deviation estimated from eight values varies, its mean hardly
}

TEST_CASE("the bias test keeps its level with three replicates and a good reference", "[study][statistical][gate]") {
    // Among 300 blocks some triples agree by chance to a hundredth of their deviation: the trap for variances with two
    // degrees of freedom.
    constexpr std::size_t blocks = 300;
    Random random(8);
    std::normal_distribution<double> normal;
    const auto draw = [&](double deviation) {
        std::vector<double> means(blocks + 1, 1.0);
        for (double& mean : means) mean += deviation * normal(random);
        return means;
    };
    int alarms = 0;
    for (int k = 0; k < repetitions; ++k) {
        BiasSide reference{{draw(0.002)}, std::vector<double>(blocks + 1, 0.002 * 0.002)}, method;
        for (int i = 0; i < 3; ++i) method.replicates.push_back(draw(0.08));
        BiasOptions options;
        options.level = 0.05;
        alarms += test_bias(method, reference, options).differs;
    }
    CAPTURE(alarms);
    CHECK(alarms <= 71);  // 50, plus three standard errors of 6.9
}

TEST_CASE("the bias test reports when it cannot judge", "[study]") {
    const std::vector<double> flat{1, 1, 1};
    BiasSide one{{flat}, {}}, two{{flat, flat}, {}}, other{{flat, flat}, {}};
    CHECK(test_bias(one, two).note == "needs two replicates");
    CHECK_FALSE(test_bias(one, two).tested);
    CHECK_FALSE(test_bias(two, other).differs);
    other.replicates = {{1, 1.01, 1.005}, {1, 1.01, 1.005}};
    const BiasTest exact = test_bias(two, other);  // without noise any difference beyond rounding counts
    CHECK(exact.differs);
    CHECK(exact.worst == 1);
    CHECK_FALSE(exact.worst_is_whole);
    CHECK(exact.worst_difference.value == Approx(-0.01 / 1.01));
}

TEST_CASE("replicates that do not show their noise are not evidence of bias", "[study]") {
    // Light in the second block is so rare that no replicate met it; the reference did, and has its own noise.
    const BiasSide reference{{{1, 0.2, 0.5}}, {1e-6, 1e-4, 1e-6}};
    BiasSide method{{{1.01, 0, 0.505}, {0.99, 0, 0.495}, {1.02, 0, 0.51}, {0.98, 0, 0.49}}, {}};
    BiasTest result = test_bias(method, reference);
    CHECK(result.tested);
    CHECK(result.worst == 1);
    CHECK_FALSE(result.differs);
    CHECK(result.blind == "none of 4 replicates has any light there");
    method.replicates[2][1] = 1e-5;
    CHECK(test_bias(method, reference).blind == "only 1 of 4 replicates have any light there");
    for (auto& replicate : method.replicates) replicate[1] = 0.01;
    CHECK(test_bias(method, reference).blind == "its replicates do not vary there");
    // Among many replicates a dark one is no reason, because the light was met often enough in total.
    method.replicates.assign(40, {1, 0.01, 0.5});
    for (std::size_t i = 0; i < 40; ++i) method.replicates[i][1] *= 1 + 0.1 * static_cast<double>(i % 5);
    method.replicates[0][1] = 0;
    CHECK(test_bias(method, reference).differs);
    // If the reference has no noise there either, the light is missing.
    method.replicates.assign(4, {1, 0, 0.5});
    CHECK(test_bias(method, {{{1, 0.2, 0.5}}, {0, 0, 0}}).differs);
    CHECK_FALSE(test_bias(method, {{{1, 0.2, 0.5}}, {}}).differs);  // for which that is unknown
}

TEST_CASE("block means and their variances", "[study]") {
    PixelArray image{20, 17, 3, std::vector<double>(20 * 17 * 3, 1.0)};
    for (std::size_t y = 0; y < 20; ++y) image.values[(y * 17 + 16) * 3 + 1] = 4;  // the last column, one pixel wide
    const std::vector<double> means = block_means(image);
    REQUIRE(means.size() == 5);
    CHECK(means[0] == 1);
    CHECK(means[1] == 2);
    CHECK(means[4] == Approx(1 + 1.0 / 17).epsilon(1e-14));
    const std::vector<double> variances = block_variances(PixelArray{20, 17, 3, std::vector<double>(20 * 17 * 3, 0.5)});
    CHECK(variances[0] == Approx(0.5 / 256).epsilon(1e-14));
    CHECK(variances[4] == Approx(0.5 / 340).epsilon(1e-14));
}

TEST_CASE("the first differing word belongs to no channel that agrees", "[study]") {
    const std::vector<TestedChannel> channels{{"direct", "C<R[DS]>[<L.>O]", "renderman", false, 0.4},
                                              {"indirect", "C[DSV]{2,}[<L.>O]", "renderman", true, 1e-9},
                                              {"two", "C[DSV]{2}[<L.>O]", "renderman", false, 0.5},
                                              {"three", "CDDD+[<L.>O]", "renderman", true, 1e-6}};
    const Counterexamples first = find_counterexamples(channels);
    CAPTURE(first.notes);
    REQUIRE(first.words.size() == 2);
    // `two` agrees, so the shortest path of `indirect` that can be wrong has three bounces.
    CHECK(first.words[0].events == first.words[1].events);
    CHECK(first.words[0].channel == "indirect");  // more significant
    CHECK(first.words[0].events == 5);
    CHECK_FALSE(first.words[0].sentence.empty());
}

TEST_CASE("spectra hold the mean square, put a wave in its ring, and are flat for white noise", "[study]") {
    std::mt19937_64 random(11);
    std::normal_distribution<double> normal;
    // Powers of two, composites, primes, one component and three, a single row.
    for (const auto& [width, height, components] :
         {std::array<std::size_t, 3>{64, 32, 3}, {30, 21, 3}, {37, 13, 1}, {1, 1, 3}, {12, 1, 2}}) {
        CAPTURE(width, height, components);
        PixelArray noise{height, width, components, std::vector<double>(height * width * components)};
        double square = 0;
        for (double& each : noise.values) {
            each = normal(random);
            square += each * each / static_cast<double>(noise.values.size());
        }
        double power = 0;
        std::size_t count = 0;
        for (const FrequencyRing& ring : radial_spectrum(noise)) {
            power += ring.power * static_cast<double>(ring.count);
            count += ring.count;
        }
        CHECK(count == width * height);
        // Sums of some thousand doubles: rounding of 2^-53 each stays below 1e-12.
        CHECK(power / static_cast<double>(count) == Approx(square).epsilon(1e-12));
    }
    // A wave of 5 cycles across 40 pixels: all power except rounding at 1/8 cycle per pixel.
    PixelArray wave{24, 40, 1, {}};
    for (int y = 0; y < 24; ++y)
        for (int x = 0; x < 40; ++x) wave.values.push_back(std::cos(2 * std::numbers::pi * 5 * x / 40.0));
    for (const FrequencyRing& ring : radial_spectrum(wave)) {
        CAPTURE(ring.frequency);
        const bool here = ring.frequency > 0.125 && ring.frequency < 0.125 * std::exp2(0.25);
        const double total = ring.power * static_cast<double>(ring.count) / (24 * 40);
        CHECK(total == Approx(here ? 0.5 : 0).margin(1e-12));
    }
    // White noise of variance 4: rings of hundreds of values, each as uncertain as its mean.
    PixelArray white{128, 128, 3, std::vector<double>(128 * 128 * 3)};
    for (double& each : white.values) each = 2 * normal(random);
    for (const FrequencyRing& ring : radial_spectrum(white))
        if (ring.count > 400) CHECK(ring.power == Approx(4).epsilon(5 / std::sqrt(1.5 * 400)));
}

TEST_CASE("the Pareto front keeps undominated points", "[study]") {
    const std::vector<CostPoint> points{{1, 5}, {2, 6}, {2, 3}, {3, 3}, {4, 1}, {2, 3}, {INFINITY, 0}};
    CHECK(pareto_front(points) == std::vector<std::size_t>{0, 2, 4});
}
