// Does a method converge to what the reference says, block by block and channel by channel? (Jung, Hanika and
// Dachsbacher, JCGT 9(2), 2020: Welch's t test on block means, for which the central limit theorem holds where single
// pixels are too skewed.)
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "experiments/study/analysis/intervals.h"
#include "experiments/study/results.h"
#include "lpe/program.h"
#include "lpe/words.h"

namespace raylex::experiments {

inline constexpr std::size_t bias_block = 16;  ///< pixels on a side
/// Of the mean: where a larger bias would be missed, not finding any is no result.
inline constexpr double largest_hidden_bias = 0.1;

/// Block means of an image over its three components, row by row, the mean of the whole image last: what a bias test
/// looks at.
std::vector<double> block_means(const PixelArray& image);
/// The variance of those means when pixels are independent, from each pixel's variance. NaN where a pixel's is not
/// finite.
std::vector<double> block_variances(const PixelArray& variance);
/// Blocks of an image of this size, without the whole.
std::size_t block_count(std::size_t width, std::size_t height);

/// One side of the test: block means of independent replicates, or a single image with its own variance.
struct BiasSide {
    std::vector<std::vector<double>> replicates;  ///< each as block_means makes it
    std::vector<double> variance;  ///< of the mean of the replicates; empty: from the replicates' scatter
};

/// Of one block over replicates: the mean, and the unbiased variance of a single replicate; 0 when there is but one.
struct BlockMoments {
    double mean = 0, variance = 0;
};
BlockMoments block_moments(const std::vector<std::vector<double>>& replicates, std::size_t block);

struct BiasOptions {
    double level = 0.01;  ///< of all tests together: half for whole images, half for blocks
    double power = 0.9;   ///< at which the minimum detectable bias is found
    double channels = 1;  ///< tested together: Sidak's correction is over channels, and blocks x channels
    /// Differences up to this share of the mean are rounding: images are kept as sums of floats.
    double rounding = 1e-6;
};

struct BiasVerdict {
    bool tested = false;
    bool differs = false;
    double worst_p = 1;     ///< of the most significant test by itself
    double adjusted_p = 1;  ///< the same, corrected for all tests
    std::size_t worst = 0;  ///< its index as in block_means
    bool worst_is_whole = false;
    /// Relative to the block's own reference, signed; the interval is at the level of the test, so it leaves out 0
    /// where the test rejects.
    Interval worst_difference, mean_difference;  ///< of the most significant test; of the whole image
    double tests = 0;                            ///< that were made, times the channels
    /// Smallest relative bias of the image's mean that is found with the stated power; infinite where it was not
    /// tested.
    double detectable_whole = 0;
    double detectable_block = 0;  ///< the same for the median block
    std::string note;             ///< why nothing was tested, or what the variance of the reference rests on
    /// Why a difference that noise does not explain rejects nothing: the method's replicates do not show their noise
    /// there. Empty: there is no such difference, or another one rejects.
    std::string blind;
};

/// Welch's statistic per block and for the whole image, two-sided, each at the level that Sidak's correction leaves,
/// with the quantiles of Student's t at the fewer degrees of freedom of the two sides. Blocks in which both sides are
/// the same and without noise are not tests. A block or image that most replicates leave black, or in which they are
/// all the same though the reference has noise, rejects nothing: their variance is not the method's.
BiasVerdict test_bias(const BiasSide& method, const BiasSide& reference, const BiasOptions& options = {});

/// A channel in which a method was found to differ, or not.
struct JudgedChannel {
    std::string name, expression, dialect;
    bool differs = false;
    double adjusted_p = 1;
};

/// The shortest paths by which a biased method can be told: those of channels that differ and of no channel that does
/// not.
struct FirstWords {
    struct Word {
        std::string channel, text, sentence;  ///< "C,- R,D L,-"; "camera, diffuse reflection, light"
        std::size_t events = 0;
        double adjusted_p = 1;
    };
    std::vector<Word> words;  ///< shortest first; ties by significance
    std::vector<std::string> notes;
};
/// Channels whose expression is everything (the beauty) say nothing and are better left out. What cannot be parsed or
/// is too large becomes a note.
FirstWords first_differing_words(std::span<const JudgedChannel> channels, const lpe::Words& words = {});

}  // namespace raylex::experiments
