#include "experiments/study/analysis/bias.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "experiments/study/analysis/distributions.h"

namespace raylex::experiments {
namespace {

/// Sums of a component over the pixels of each block, and over the whole image last, with the number of values in each.
struct BlockSums {
    std::vector<double> sums, counts;
};

BlockSums sum_blocks(const PixelArray& array) {
    const std::size_t across = (array.width + bias_block - 1) / bias_block,
                      blocks = block_count(array.width, array.height);
    BlockSums result{std::vector<double>(blocks + 1, 0.0), std::vector<double>(blocks + 1, 0.0)};
    for (std::size_t y = 0; y < array.height; ++y)
        for (std::size_t x = 0; x < array.width; ++x) {
            const std::size_t block = y / bias_block * across + x / bias_block;
            for (std::size_t c = 0; c < array.components; ++c)
                result.sums[block] += array.values[(y * array.width + x) * array.components + c];
            result.counts[block] += static_cast<double>(array.components);
        }
    for (std::size_t block = 0; block < blocks; ++block) {
        result.sums[blocks] += result.sums[block];
        result.counts[blocks] += result.counts[block];
    }
    return result;
}

/// Returns a block's mean and the variance of that mean. A single image without its own variance counts as exact.
BlockMoments mean_of_side(const BiasSide& side, std::size_t block) {
    BlockMoments moments = block_moments(side.replicates, block);
    moments.variance =
        side.variance.empty() ? moments.variance / static_cast<double>(side.replicates.size()) : side.variance[block];
    return moments;
}

/// Returns the degrees of freedom of a side's variance: few from replicates, practically infinite from pixel estimates.
double degrees_of(const BiasSide& side) {
    if (!side.variance.empty() || side.replicates.size() < 2) return std::numeric_limits<double>::infinity();
    return static_cast<double>(side.replicates.size() - 1);
}

/// Returns the smaller number of degrees of freedom of the two sides, for the quantiles of Student's t. Welch's degrees
/// of freedom, and Cochran's weights, depend on the same variances as the statistic: if a few replicates agree closely
/// by chance, both use the other side's many degrees, and in the far tails that Sidak's correction needs, false alarms
/// become several times too frequent. With the smaller number the level is never exceeded, because the sum of an
/// estimated and a known variance scatters less than chi squared.
double least_degrees(const BiasSide& method, const BiasSide& reference) {
    return std::min(degrees_of(method), degrees_of(reference));
}

struct Test {
    std::size_t block = 0;
    double difference = 0, reference = 0, standard_error = 0;
    /// |difference| in units of the critical value; a value above 1 rejects. Infinite if nothing is random and the
    /// sides differ.
    double excess = 0;
    std::string blind;  ///< why the method's replicates do not show their noise here; usually empty
    [[nodiscard]] bool rejects() const { return excess > 1 && blind.empty(); }
};

/// If light is found `events` times, the skewness of its mean is at least 1 / sqrt(events). At 0.18 the tails of
/// Student's t are still valid.
constexpr double fewest_events = 30;

std::string blindness(const BiasSide& method, std::size_t block, double method_spread, double reference_spread) {
    const std::size_t count = method.replicates.size();
    if (!method.variance.empty() || count < 2 || reference_spread == 0) return {};
    const auto lit = static_cast<std::size_t>(
        std::count_if(method.replicates.begin(), method.replicates.end(),
                      [block](const std::vector<double>& means) { return means[block] != 0; }));
    const std::string of_all = std::to_string(lit) + " of " + std::to_string(count) + " replicates";
    if (lit == 0) return "none of " + std::to_string(count) + " replicates has any light there";
    // Poisson: with k events in each replicate, a fraction exp(-k) of the replicates stays black.
    const double n = static_cast<double>(count), dark = 1 - static_cast<double>(lit) / n;
    if (dark > 0 && -n * std::log(dark) < fewest_events) return "only " + of_all + " have any light there";
    return method_spread == 0 ? "its replicates do not vary there" : std::string();
}

/// Half of the level is for the whole images of all channels, half for their blocks, so that the number of blocks does
/// not hide a bias of the whole image.
struct Family {
    Family(const BiasOptions& options, double number, double degrees) : tests(std::max(1.0, number)) {
        const double level = sidak_level(options.level / 2, tests);
        critical = -student_t_quantile(level / 2, degrees);
        shift = detectable_shift(level, options.power, degrees);
    }
    double tests, critical = 0, shift = 0;
};

double relative(double difference, double reference) {
    return reference != 0    ? difference / std::abs(reference)
           : difference == 0 ? 0
                             : std::copysign(INFINITY, difference);
}

Interval interval_of(const Test& test, const Family& family) {
    const double half = family.critical * test.standard_error;
    return {relative(test.difference, test.reference),
            relative(test.difference - half, test.reference),
            relative(test.difference + half, test.reference),
            {},
            {}};
}

std::vector<Test> make_tests(const BiasSide& method, const BiasSide& reference, const BiasOptions& options) {
    std::vector<Test> tests;
    for (std::size_t block = 0; block < method.replicates.front().size(); ++block) {
        const BlockMoments a = mean_of_side(method, block), b = mean_of_side(reference, block);
        Test test{block, a.mean - b.mean, b.mean, std::sqrt(a.variance + b.variance), 0, {}};
        if (!std::isfinite(test.standard_error) || !std::isfinite(test.difference)) continue;
        // Differences below the rounding of the images are not visible, and a spread below it counts as no spread.
        const double rounding = options.rounding * std::max(std::abs(a.mean), std::abs(b.mean));
        if (test.standard_error <= rounding) {
            if (std::abs(test.difference) <= rounding) continue;
            test.excess = std::numeric_limits<double>::infinity();
        }
        const auto spread = [rounding](double variance) { return std::sqrt(variance) <= rounding ? 0 : variance; };
        // A single image without a variance counts as exact, without evidence.
        const bool known = !reference.variance.empty() || reference.replicates.size() > 1;
        test.blind = blindness(method, block, spread(a.variance), known ? spread(b.variance) : 1);
        tests.push_back(test);
    }
    return tests;
}

}  // namespace

std::size_t block_count(std::size_t width, std::size_t height) {
    return ((width + bias_block - 1) / bias_block) * ((height + bias_block - 1) / bias_block);
}

BlockMoments block_moments(const std::vector<std::vector<double>>& replicates, std::size_t block) {
    BlockMoments moments;
    const auto n = static_cast<double>(replicates.size());
    for (const std::vector<double>& replicate : replicates) moments.mean += replicate[block] / n;
    if (n < 2) return moments;
    double squares = 0;
    for (const std::vector<double>& replicate : replicates)
        squares += (replicate[block] - moments.mean) * (replicate[block] - moments.mean);
    moments.variance = squares / (n - 1);
    return moments;
}

std::vector<double> block_means(const PixelArray& image) {
    BlockSums blocks = sum_blocks(image);
    for (std::size_t i = 0; i < blocks.sums.size(); ++i) blocks.sums[i] /= blocks.counts[i];
    return blocks.sums;
}

std::vector<double> block_variances(const PixelArray& variance) {
    // The components of a pixel share their paths. In the worst case they are fully correlated, and their mean has the
    // variance of one component. (sum over pixels of the mean over components of the variances) / pixels^2 is an upper
    // bound.
    BlockSums blocks = sum_blocks(variance);
    const auto components = static_cast<double>(variance.components);
    for (std::size_t i = 0; i < blocks.sums.size(); ++i) {
        const double pixels = blocks.counts[i] / components;
        blocks.sums[i] /= components * pixels * pixels;
        if (!std::isfinite(blocks.sums[i])) blocks.sums[i] = std::numeric_limits<double>::quiet_NaN();
    }
    return blocks.sums;
}

namespace {

/// Returns the test of the block whose relative standard error is the median; null without blocks.
const Test* median_test(std::vector<const Test*>& tests) {
    if (tests.empty()) return nullptr;
    const auto middle = tests.begin() + static_cast<std::ptrdiff_t>(tests.size() / 2);
    std::nth_element(tests.begin(), middle, tests.end(), [](const Test* a, const Test* b) {
        return a->standard_error * std::abs(b->reference) < b->standard_error * std::abs(a->reference);
    });
    return *middle;
}

/// Why a side cannot be tested, or nullptr.
const char* missing_side(const BiasSide& method, const BiasSide& reference) {
    if (method.replicates.size() < 2 && method.variance.empty()) return "needs two replicates";
    return reference.replicates.empty() ? "no reference" : nullptr;
}

}  // namespace

BiasTest test_bias(const BiasSide& method, const BiasSide& reference, const BiasOptions& options) {
    BiasTest verdict;
    if (const char* missing = missing_side(method, reference); missing != nullptr) {
        verdict.note = missing;
        return verdict;
    }
    if (reference.replicates.size() < 2 && reference.variance.empty())
        verdict.note = "the reference's variance is unknown; it counts as exact";
    const std::size_t whole = method.replicates.front().size() - 1;
    std::vector<Test> tests = make_tests(method, reference, options);
    const BlockMoments mean = mean_of_side(method, whole), truth = mean_of_side(reference, whole);
    const bool finite = std::isfinite(mean.mean + truth.mean + mean.variance + truth.variance);
    if (!finite) verdict.detectable_whole = std::numeric_limits<double>::infinity();
    if (tests.empty() && !finite) {
        verdict.note = "a mean or its variance is not finite";
        return verdict;
    }
    verdict.tested = true;
    if (tests.empty()) {
        verdict.note = "both are equal everywhere, without noise";
        return verdict;
    }
    const auto has_whole = static_cast<std::size_t>(tests.back().block == whole);
    const double blocks = static_cast<double>(tests.size() - has_whole);
    verdict.tests = static_cast<double>(tests.size()) * options.channels;
    const double degrees = least_degrees(method, reference);
    const Family of_whole(options, options.channels, degrees), of_block(options, blocks * options.channels, degrees);
    const auto family_of = [&](const Test& test) -> const Family& { return test.block == whole ? of_whole : of_block; };
    const auto detectable = [&](const Test& test) {
        return std::abs(relative(family_of(test).shift * test.standard_error, test.reference));
    };
    const Test* worst = &tests.front();
    std::vector<const Test*> in_blocks;
    for (Test& test : tests) {
        if (!std::isinf(test.excess))
            test.excess = std::abs(test.difference) / (family_of(test).critical * test.standard_error);
        if (test.rejects() > worst->rejects() || (test.rejects() == worst->rejects() && test.excess > worst->excess))
            worst = &test;
        if (test.block != whole) {
            in_blocks.push_back(&test);
            continue;
        }
        if (test.standard_error > 0) verdict.detectable_whole = detectable(test);
        verdict.mean_difference = interval_of(test, of_whole);
    }
    verdict.worst_p =
        std::isinf(worst->excess) ? 0 : student_t_two_sided(worst->difference / worst->standard_error, degrees);
    verdict.adjusted_p = std::min(1.0, 2 * sidak_adjusted(verdict.worst_p, family_of(*worst).tests));
    verdict.differs = worst->rejects();
    if (worst->excess > 1) verdict.blind = worst->blind;
    verdict.worst = worst->block;
    verdict.worst_is_whole = worst->block == whole;
    verdict.worst_difference = interval_of(*worst, family_of(*worst));
    if (const Test* middle = median_test(in_blocks); middle != nullptr && middle->standard_error > 0)
        verdict.detectable_block = detectable(*middle);
    return verdict;
}

}  // namespace raylex::experiments
