// Which words make a pixel bright, and which make an image noisy.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "display/output/atlas/atlas_file.h"
#include "lpe/result.h"

namespace raylex::experiments {

struct BrightWord {
    std::uint32_t word = 0;
    std::array<double, 3> rgb{};
    double mean = 0;   ///< (R + G + B) / 3
    double error = 0;  ///< its standard error; infinite when there is no telling
};

struct BrightPixel {
    std::array<float, 4> rgba{};
    double mean = 0, error = 0, samples = 0;
    std::vector<BrightWord> words;  ///< brightest first, by |mean|
    std::size_t more = 0;           ///< words beside these
};

/// The `most` words that make a pixel bright. Errors: a pixel outside the image; a damaged file.
Result<BrightPixel> bright_words(display::AtlasFile& atlas, int x, int y, std::size_t most);

/// The `most` pixels, as x and y, that are furthest above the median of their neighbours, by (R + G + B) / 3. Errors: a
/// damaged file.
Result<std::vector<std::array<int, 2>>> brightest_outliers(display::AtlasFile& atlas, std::size_t most);

/// A layer that `ask --suggest` proposes.
struct SuggestedLayer {
    std::string name;
    std::string expression;  ///< renderman
    double light = 0;        ///< share of the image's light
    double noise = 0;        ///< share of the image's variance, words taken as if each were alone
};

/// A partition that isolates what is noisy: words by what their scatterings and lights are, labels and lobes aside; the
/// `most` noisiest of these are layers, disjoint by what they are, and a rest takes what is left, last in the list and
/// without an expression. Empty when no pixel tells its noise. Errors: a damaged file.
Result<std::vector<SuggestedLayer>> suggest_partition(display::AtlasFile& atlas, std::size_t most);

}  // namespace raylex::experiments
