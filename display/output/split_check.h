// Do the layers of a split sum to what they split, pixel by pixel (Law 1)? And how do two images differ?
#pragma once

#include <string>
#include <vector>

#include "display/output/exr_reader.h"
#include "lpe/result.h"

namespace raylex::display {

/// |sum - of| against the rounding bound of the stored types, u (sum of |layers| + |of|), with u = 2^-23 for float and
/// 2^-10 for half (the coarser of the types present).
struct SplitVerdict {
    std::string partition, of;
    std::vector<std::string> layers;
    double largest_absolute = 0, largest_relative = 0;     ///< relative to sum of |layers| + |of|
    int absolute_x = 0, absolute_y = 0, relative_x = 0, relative_y = 0;   ///< the pixels where they occur
    double bound = 0;                                      ///< on largest_relative
    std::size_t non_finite = 0, exceeding = 0;             ///< pixels
    bool holds = false;
    std::vector<float> residual;                           ///< [height * width] |sum - of| / (sum of |layers| + |of|), worst component
};

/// `layer_globs` (* and ?) choose the layers of the sum; each must match something.
Result<SplitVerdict> check_split(const ExrImage& image, const std::string& of, const std::vector<std::string>& layer_globs);
/// Every partition declared in the file's header.
Result<std::vector<SplitVerdict>> check_declared_splits(const ExrImage& image);

enum class CompareMetric : std::uint8_t { relmse, mse, mae, mape, mean_ratio };
/// The metric's formula in words, a the image and b the reference: "mean((a-b)^2 / (b^2 + 0.01))".
const char* formula(CompareMetric metric);
/// `component`: 'R', 'G', 'B', 'Y' (luminance) or 'A' for all three components together. Converts primaries when the
/// files' chromaticities differ.
Result<double> compare(const ExrImage& image, const ExrImage& reference, CompareMetric metric, const std::string& layer, char component);

/// Shell-style match of `name` against `pattern` with * and ?.
bool glob_match(std::string_view pattern, std::string_view name);

}  // namespace raylex::display
