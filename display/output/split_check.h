// Do the layers of a split sum to what they split, pixel by pixel (Law 1)? And how do two images differ?
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "display/output/error_metrics.h"
#include "display/output/exr_reader.h"
#include "lpe/result.h"

namespace raylex::display {

/// |sum - of| against the rounding bound of the stored types, u (sum of |layers| + |of|), with u = 2^-23 for float and
/// 2^-10 for half (the coarser of the types present): twice what rounding each value to nearest can cost.
///
/// That holds for normal numbers. Below 2^-14 a half is spaced by 2^-24 whatever its size, so there the absolute
/// spacing (2^-24 for half, 2^-149 for float) of each value is allowed on top; a difference that only this explains
/// counts as a relative one of at most u.
struct SplitVerdict {
    std::string partition, of;
    std::vector<std::string> layers;
    double largest_absolute = 0, largest_relative = 0;                   ///< relative to sum of |layers| + |of|
    int absolute_x = 0, absolute_y = 0, relative_x = 0, relative_y = 0;  ///< the pixels where they occur
    double bound = 0;                                                    ///< on largest_relative
    std::size_t non_finite = 0, exceeding = 0;                           ///< pixels
    int non_finite_x = 0, non_finite_y = 0;                              ///< the first one that is not finite
    bool holds = false;
    /// [height * width] |sum - of| / (sum of |layers| + |of|), worst component; infinite where a value is not finite.
    std::vector<float> residual;
};

/// `layer_globs` (* and ?) choose the layers of the sum; each must match something. A layer that several globs match
/// counts once; a glob with wildcards passes over `of` itself. Layers of unsigned integers, or of planes that are
/// neither R G B nor X Y Z nor a single one, are errors.
Result<SplitVerdict> check_split(const ExrImage& image, const std::string& of,
                                 const std::vector<std::string>& layer_globs);
/// Every partition declared in the file's header, in its order; an empty list when none is.
Result<std::vector<SplitVerdict>> check_declared_splits(const ExrImage& image);

/// Heat map of a verdict's residual as PNG, one pixel per pixel. The scale is logarithmic and its lightness rises with
/// the residual: black for none, dark blue to violet within the bound (from bound / 1024), red to pale yellow beyond it
/// (up to 1). Cyan marks values that are not finite. The verdict must come from an image of this size.
Status write_residual_png(const std::string& path, const SplitVerdict& verdict, int width, int height);

/// One metric of a layer; `component`: 'R', 'G', 'B' (or the first, second, third plane of X Y Z), 'Y' (luminance of
/// R G B by the reference's primaries; plane Y of X Y Z) or 'A' for all three components together. A single plane
/// stands for all of them.
///
/// R G B of `image` are converted to the reference's primaries when the files' chromaticities differ (none means
/// Rec. 709, as the OpenEXR documentation says), whites adapted by Bradford. Means are over all pixels, in double.
/// Equal infinities (depth where nothing was hit) count as no difference, and mean_ratio leaves them out; any other
/// value that is not finite makes the result inf or an error. Errors: no such layer in either, sizes differ, an unknown
/// component, a metric without a value, as is the ratio to a mean of 0.
Result<double> compare(const ExrImage& image, const ExrImage& reference, ErrorMetric metric, const std::string& layer,
                       char component);

/// Shell-style match of `name` against `pattern` with * and ?.
bool glob_match(std::string_view pattern, std::string_view name);

}  // namespace raylex::display
