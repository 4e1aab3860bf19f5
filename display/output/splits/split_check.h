// Checks that the layers of a split sum to what they split, pixel by pixel (Law 1), and compares two images.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "display/output/metrics/error_metrics.h"
#include "display/output/reader/exr_reader.h"
#include "lpe/result.h"

namespace raylex::display {

/// The allowance beyond rounding: |sum - of| <= rounding + absolute + relative (sum of |terms| + |of|).
struct Allowance {
    double absolute = 0, relative = 0;
    std::string reason;                   ///< the reason, as text
    bool instead_of_compression = false;  ///< replaces the allowances for lossy compression
};

/// Negative values in the layers of a split and in what they split.
struct NegativeValues {
    std::size_t pixels = 0;
    float lowest = 0;  ///< over all, with its pixel and its layer
    int x = 0, y = 0;
    std::string layer;
    /// Adds the values of other pixels or layers, whose rows begin at `first_row`.
    void add(const NegativeValues& more, int first_row = 0);
};

/// Light by which a sum differs from what it splits, beyond what is allowed, over the components of all pixels.
struct LightDifference {
    double light = 0, square = 0;  ///< sums of the difference and of its square
    double largest = 0;
    int x = 0, y = 0;  ///< the pixel of the largest difference
    std::size_t pixels = 0;
    std::vector<std::pair<std::string, double>> candidates;  ///< layers, with the squared distance from the difference
    /// The layer that equals the difference up to 1 % (root mean square); empty if none does.
    [[nodiscard]] std::string cause() const;
};

/// The differences of a split in the words of compositors.
struct Rebuild {
    double whole = 0;                                ///< sum of |of| over the components of all pixels
    LightDifference unassigned, doubled;             ///< of - sum where it is positive, and where it is negative
    std::map<std::string, double> lost;              ///< unassigned light where a factor of a product is 0, by factor
    std::map<std::string, NegativeValues> negative;  ///< by layer, what is split included
    std::vector<float> light;  ///< [pixel, component] of - sum beyond what is allowed, else 0; empty if all are 0
};

/// cannot_tell: every pixel only gives a bound, and no bound decides.
enum class SplitAnswer : std::uint8_t { holds_to_rounding, holds_as_allowed, does_not_hold, cannot_tell };

/// The result of a check: |sum - of| compared with the error that rounding explains, and with the allowance beyond it.
///
/// Rounding. A stored value is within one unit in the last place of its type from the true value (stored_precision.h):
/// float 2^-23, half 2^-10; below the smallest normal number the spacing applies. These errors propagate through the
/// sum: (a + e)(b + f) has the error |a|f + |b|e + ef. The writer of the image added in float, so each addition and
/// product costs 2^-24 of its input magnitudes, in any order. raylex rounds sums that are exact, so in its files
/// additions cost nothing: |sum - of| <= u (sum of |layers| + |of|) with u = 2^-23 is Law 1.
///
/// Allowance. Lossy compressions count with their measured loss, on the planes that use them; plus an Allowance.
struct SplitResult {
    std::string partition, of;
    std::vector<std::string> layers;
    double largest_absolute = 0, largest_relative = 0;                   ///< relative to sum of |terms| + |of|
    int absolute_x = 0, absolute_y = 0, relative_x = 0, relative_y = 0;  ///< the pixels where they occur
    double bound = 0;                                                    ///< relative bound of the rounding error
    std::string bound_reason;              ///< "float, 2^-23; 8 operations in float, 2^-24 each"
    std::vector<std::string> allowed_for;  ///< reasons for allowances, empty if there are none
    Allowance allowance;
    std::vector<std::string> unexplained;       ///< lossy compressions without an allowance
    std::size_t past_rounding = 0;              ///< pixels that hold only with the allowance
    std::size_t non_finite = 0, exceeding = 0;  ///< pixel counts; exceeding: beyond the allowance
    std::size_t clamped = 0;  ///< pixels with a value at the largest number of its type: the true value is at least
                              ///< that
    std::size_t pixels = 0, undecided = 0;  ///< of the image; undecided: pixels that such values leave open
    [[nodiscard]] std::size_t checked() const { return pixels - undecided; }
    int non_finite_x = 0, non_finite_y = 0;  ///< the first value that is not finite
    std::string non_finite_layer;            ///< its layer; empty if several values overflow together
    SplitAnswer answer = SplitAnswer::does_not_hold;
    bool holds = false;  ///< to rounding or with the allowance
    /// Wherever the split does not hold, the sum is too small and no value is negative: the layers miss light.
    bool never_above = false;
    NegativeValues negative;
    Rebuild rebuild;  ///< not filled by SplitSum
    /// [height * width] |sum - of| relative to the allowance, times bound + allowance.relative, at most 1/2 (for a
    /// plain sum without allowance: relative to sum of |layers| + |of|), for the worst component; infinite where a
    /// value is not finite.
    std::vector<float> residual;
};

/// Checks one sum. `sums` use the notation of layer_arithmetic.h: layers, globs and expressions separated by commas.
/// Errors: layers of unsigned integers, or with planes that are neither R G B nor X Y Z nor a single one.
Result<SplitResult> check_split(const ExrImage& image, const std::string& of, const std::vector<std::string>& sums,
                                const Allowance& allowance = {});
/// Checks every partition that the file's header declares, in order; returns an empty list if there is none.
Result<std::vector<SplitResult>> check_declared_splits(const ExrImage& image, const Allowance& allowance = {});

/// Checks a file of any size, read in bands of at most a quarter of a GiB.
Result<SplitResult> check_split(const ExrBands& file, const std::string& of, const std::vector<std::string>& sums,
                                const Allowance& allowance = {});
Result<std::vector<SplitResult>> check_declared_splits(const ExrBands& file, const Allowance& allowance = {});

/// Writes the residual of a result as a heat map in PNG, one pixel per pixel. The scale is logarithmic, and lightness
/// rises with the residual: black for none, dark blue to violet within the allowance (from a 1024th of it), red to pale
/// yellow beyond it (up to 1). Cyan marks values that are not finite. The result must be of an image of this size.
Status write_residual_png(const std::string& path, const SplitResult& result, int width, int height);

/// Computes one metric of a layer. `component` is 'R', 'G', 'B' (or the first, second, third plane of X Y Z), 'Y'
/// (luminance of R G B by the reference's primaries; plane Y of X Y Z) or 'A' for all three components together. A
/// single plane serves as all of them.
///
/// If the chromaticities of the files differ, R G B of `image` are converted to the reference's primaries, with whites
/// adapted by Bradford; files without chromaticities have Rec. 709, according to the OpenEXR documentation. Means are
/// over all pixels, in double. Equal infinities (depth without a hit) count as no difference, and mean_ratio excludes
/// them; any other value that is not finite makes the result inf or an error. Errors: a layer is missing in one image,
/// different sizes, an unknown component, a metric without a value, such as the ratio to a mean of 0.
Result<double> compare(const ExrImage& image, const ExrImage& reference, ErrorMetric metric, const std::string& layer,
                       char component);

/// Matches `name` against a shell-style `pattern` with * and ?.
bool glob_match(std::string_view pattern, std::string_view name);

}  // namespace raylex::display
