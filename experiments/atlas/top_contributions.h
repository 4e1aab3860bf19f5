// Finds the words that make a pixel bright and the words that make an image noisy.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "display/output/atlas/atlas_file.h"
#include "lpe/result.h"

namespace raylex::experiments {

struct TopContribution {
    std::uint32_t word = 0;
    std::array<double, 3> rgb{};
    double mean = 0;   ///< (R + G + B) / 3
    double error = 0;  ///< standard error of `mean`; infinite if unknown
};

struct PixelContributions {
    std::array<float, 4> rgba{};
    double mean = 0, error = 0, samples = 0;
    std::vector<TopContribution> words;  ///< brightest first, by |mean|
    std::size_t more = 0;                ///< number of further words
};

/// Returns the `most` brightest words of a pixel. Errors: a pixel outside the image; a damaged file.
Result<PixelContributions> top_contributions(display::AtlasFile& atlas, int x, int y, std::size_t most);

/// Returns the (x, y) of the `most` pixels that exceed the median of their neighbours most, by (R + G + B) / 3. Errors:
/// a damaged file.
Result<std::vector<std::array<int, 2>>> brightest_outliers(display::AtlasFile& atlas, std::size_t most);

/// A layer that `ask --suggest` proposes.
struct SuggestedLayer {
    std::string name;
    std::string expression;  ///< in the dialect renderman
    double light = 0;        ///< fraction of the image's light
    double noise = 0;        ///< fraction of the image's variance, with words treated as independent
};

/// Returns a partition that isolates noise. Words are grouped by the types of their scattering events and lights;
/// labels and lobes are ignored. The `most` noisiest groups become layers, which are disjoint by construction; the last
/// entry is the rest, without an expression. Empty if the noise of no pixel is known. Errors: a damaged file.
Result<std::vector<SuggestedLayer>> suggest_partition(display::AtlasFile& atlas, std::size_t most);

}  // namespace raylex::experiments
