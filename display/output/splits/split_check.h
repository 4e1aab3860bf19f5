// Do the layers of a split sum to what they split, pixel by pixel (Law 1)? And how do two images differ?
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "display/output/metrics/error_metrics.h"
#include "display/output/reader/exr_reader.h"
#include "lpe/result.h"

namespace raylex::display {

/// What may be on top of rounding: |sum - of| <= rounding + absolute + relative (sum of |terms| + |of|).
struct Allowance {
    double absolute = 0, relative = 0;
    std::string reason;                   ///< what it is for, in words
    bool instead_of_compression = false;  ///< lossy compressions then add nothing of their own
};

/// Of the layers of a split and of what is split.
struct NegativeValues {
    std::size_t pixels = 0;
    float lowest = 0;  ///< of all, with its pixel and its layer
    int x = 0, y = 0;
    std::string layer;
};

/// cannot_tell: of every pixel the file has a bound alone, and no bound decides.
enum class SplitAnswer : std::uint8_t { holds_to_rounding, holds_as_allowed, does_not_hold, cannot_tell };

/// |sum - of| against what rounding explains, and what is allowed beyond it.
///
/// Rounding. A stored value lies within one step of its type's last place of the one that was meant
/// (stored_precision.h): float 2^-23, half 2^-10; below the smallest normal number the spacing counts. These errors go
/// through the arithmetic of the sum, (a + e)(b + f) being off by |a|f + |b|e + ef. Whoever made the image added in
/// float: each addition and product costs 2^-24 of the magnitudes that went in, in any order. raylex rounds sums that
/// are exact, so nothing is granted for additions in its files: |sum - of| <= u (sum of |layers| + |of|) with u = 2^-23
/// is Law 1.
///
/// Allowed. Lossy compressions by what was measured of them, on planes that have them; and an Allowance.
struct SplitVerdict {
    std::string partition, of;
    std::vector<std::string> layers;
    double largest_absolute = 0, largest_relative = 0;                   ///< relative to sum of |terms| + |of|
    int absolute_x = 0, absolute_y = 0, relative_x = 0, relative_y = 0;  ///< the pixels where they occur
    double bound = 0;                                                    ///< what rounding may cost at most, relative
    std::string bound_reason;              ///< "float, 2^-23; 8 operations in float, 2^-24 each"
    std::vector<std::string> allowed_for;  ///< reasons of what is allowed on top, empty when nothing is
    Allowance allowance;
    std::vector<std::string> unexplained;       ///< lossy compressions that nothing is allowed for
    std::size_t past_rounding = 0;              ///< pixels that hold only as allowed
    std::size_t non_finite = 0, exceeding = 0;  ///< pixels; exceeding: past what is allowed
    std::size_t clamped = 0;  ///< pixels with a value at the largest number of its type: what it was is at least that
    std::size_t pixels = 0, undecided = 0;  ///< of the image; of these the ones that such values leave open
    [[nodiscard]] std::size_t judged() const { return pixels - undecided; }
    int non_finite_x = 0, non_finite_y = 0;  ///< the first one that is not finite
    std::string non_finite_layer;            ///< and the layer that it is in, empty for values that overflow together
    SplitAnswer answer = SplitAnswer::does_not_hold;
    bool holds = false;  ///< to rounding or as allowed
    /// Where it does not hold the sum is too small, and no value there is negative: light that no layer has.
    bool never_above = false;
    NegativeValues negative;
    /// [height * width] |sum - of| as a part of what is allowed, times bound + allowance.relative, at most 1/2 (a plain
    /// sum that is allowed nothing: relative to sum of |layers| + |of|), worst component; infinite where a value is not
    /// finite.
    std::vector<float> residual;
};

/// `sums` in the notation of layer_arithmetic.h: layers, globs and expressions between commas. Layers of unsigned
/// integers, or of planes that are neither R G B nor X Y Z nor a single one, are errors.
Result<SplitVerdict> check_split(const ExrImage& image, const std::string& of, const std::vector<std::string>& sums,
                                 const Allowance& allowance = {});
/// Every partition declared in the file's header, in its order; an empty list when none is.
Result<std::vector<SplitVerdict>> check_declared_splits(const ExrImage& image, const Allowance& allowance = {});

/// The same of a file of any size: read band by band, of which each takes a quarter of a GiB at most.
Result<SplitVerdict> check_split(const ExrBands& file, const std::string& of, const std::vector<std::string>& sums,
                                 const Allowance& allowance = {});
Result<std::vector<SplitVerdict>> check_declared_splits(const ExrBands& file, const Allowance& allowance = {});

/// Heat map of a verdict's residual as PNG, one pixel per pixel. The scale is logarithmic and its lightness rises with
/// the residual: black for none, dark blue to violet within what is allowed (from a 1024th of it), red to pale yellow
/// beyond it (up to 1). Cyan marks values that are not finite. The verdict must come from an image of this size.
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
