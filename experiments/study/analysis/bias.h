// Tests whether a method converges to the reference, by block and channel (Jung, Hanika and Dachsbacher, JCGT 9(2),
// 2020: Welch's t test on block means, for which the central limit theorem holds although single pixels are too
// skewed).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "experiments/study/analysis/intervals.h"
#include "experiments/study/results.h"
#include "lpe/path_strings.h"
#include "lpe/program.h"

namespace raylex::experiments {

inline constexpr std::size_t bias_block = 16;  ///< block size in pixels
/// Relative to the mean. If the test would miss a larger bias, finding no bias is not a result.
inline constexpr double largest_hidden_bias = 0.1;

/// Returns the block means of an image over its three components, row by row, and the mean of the whole image last.
std::vector<double> block_means(const PixelArray& image);
/// Returns the variances of these means from the variances of the pixels, which are assumed independent. NaN if a
/// pixel's variance is not finite.
std::vector<double> block_variances(const PixelArray& variance);
/// Returns the number of blocks in an image of this size, without the whole image.
std::size_t block_count(std::size_t width, std::size_t height);

/// One side of the test: block means of independent replicates, or of a single image with its own variance.
struct BiasSide {
    std::vector<std::vector<double>> replicates;  ///< each from block_means
    std::vector<double> variance;  ///< of the mean of the replicates; empty: estimated from the replicates
};

/// Moments of one block over the replicates: the mean, and the unbiased variance of a single replicate (0 with one
/// replicate).
struct BlockMoments {
    double mean = 0, variance = 0;
};
BlockMoments block_moments(const std::vector<std::vector<double>>& replicates, std::size_t block);

struct BiasOptions {
    double level = 0.01;  ///< of all tests together: half for whole images, half for blocks
    double power = 0.9;   ///< power at which the detectable bias is computed
    /// number of channels tested together, for Sidak's correction over channels and over blocks x channels
    double channels = 1;
    /// Differences up to this fraction of the mean count as rounding, because images are sums of floats.
    double rounding = 1e-6;
};

struct BiasTest {
    bool tested = false;
    bool differs = false;
    double worst_p = 1;     ///< p of the most significant test by itself
    double adjusted_p = 1;  ///< `worst_p` corrected for all tests
    std::size_t worst = 0;  ///< index of that test as in block_means
    bool worst_is_whole = false;
    /// Signed differences relative to the reference in that place. The intervals are at the level of the test, so they
    /// exclude 0 exactly if the test rejects.
    Interval worst_difference, mean_difference;  ///< of the most significant test; of the whole image
    double tests = 0;                            ///< number of tests, times the number of channels
    /// The smallest relative bias of the image's mean that the test finds with the stated power; infinite if it was not
    /// tested.
    double detectable_whole = 0;
    double detectable_block = 0;  ///< the smallest relative bias of a block, for the median block
    std::string note;             ///< why nothing was tested, or the source of the reference's variance
    /// The reason why a difference above the noise does not reject: the replicates do not show their noise there.
    /// Empty if there is no such difference, or if another one rejects.
    std::string blind;
};

/// Computes Welch's statistic for each block and for the whole image, two-sided, at the level of Sidak's correction,
/// with quantiles of Student's t for the smaller number of degrees of freedom of the two sides. Blocks that are equal
/// on both sides and without noise are not tests. A block or image does not reject if most replicates are black in it,
/// or if all replicates are equal although the reference has noise: then their variance is not that of the method.
BiasTest test_bias(const BiasSide& method, const BiasSide& reference, const BiasOptions& options = {});

/// A channel with the result of its bias test.
struct TestedChannel {
    std::string name, expression, dialect;
    bool differs = false;
    double adjusted_p = 1;
};

/// The shortest paths that show the error of a biased method: paths in a channel that differs and in no channel that
/// does not.
struct Counterexamples {
    struct Counterexample {
        std::string channel, text, sentence;  ///< "C,- R,D L,-"; "camera, diffuse reflection, light"
        std::size_t events = 0;
        double adjusted_p = 1;
    };
    std::vector<Counterexample> words;  ///< shortest first; ties by significance
    std::vector<std::string> notes;
};
/// Finds the shortest paths that show a difference. The caller omits channels that accept every path (the beauty),
/// which carry no information. A channel that does not parse or is too large becomes a note.
Counterexamples find_counterexamples(std::span<const TestedChannel> channels, const lpe::PathStrings& words = {});

}  // namespace raylex::experiments
