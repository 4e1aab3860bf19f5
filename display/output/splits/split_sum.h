// The arithmetic of a split check, taking its layers in one after another: writers feed it what they are about to
// store, readers what they found.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "display/output/splits/split_check.h"

namespace raylex::display {

/// Three components of a layer as stored; a layer of a single plane shows it three times.
struct SplitLayer {
    std::array<std::span<const float>, 3> planes;
    std::array<StoredType, 3> types{};
};

/// Which way the value that was meant may lie beyond the stored one: beyond the largest number of its type.
using Open = std::uint8_t;
inline constexpr Open open_above = 1, open_below = 2;
[[nodiscard]] inline Open open_of(double value, double largest) {
    return value == largest ? open_above : value == -largest ? open_below : Open{0};
}
[[nodiscard]] inline Open negated(Open open) {
    return static_cast<Open>((open & open_above) << 1 | (open & open_below) >> 1);
}

/// One component of one pixel.
struct SplitError {
    double absolute = 0;  ///< |sum - of|
    double scale = 0;     ///< sum of |terms| + |of|
    double rounding = 0;  ///< what rounding explains
    double allowed = 0;   ///< and what is allowed in all, >= rounding
    double sum = 0, whole = 0;
    bool negative = false;  ///< some value of the pixel is
    Open open = 0;          ///< which way sum - of may be further than it stands
};

/// Sets the answer by the counts of pixels.
void conclude(SplitVerdict& verdict);
/// Where the scale of a residual map goes from allowed to not: bound + allowance.relative, at most 1/2.
[[nodiscard]] double residual_limit(double bound, const Allowance& allowance);

/// Pixels in any order of a file's, to a verdict.
class VerdictTally {
  public:
    /// `unit`: the largest relative error by rounding.
    VerdictTally(int width, std::size_t pixels, double unit, const Allowance& allowance, bool with_residual);
    /// `clamped`: SplitVerdict::clamped.
    void add(std::size_t pixel, std::array<SplitError, 3> components, bool clamped = false);
    [[nodiscard]] SplitVerdict finish();

  private:
    int width_;
    double limit_;
    SplitVerdict verdict_;
};

class SplitSum {
  public:
    /// `cancelled`: SumRules::cancelled.
    SplitSum(int width, int height, double cancelled = 0);
    /// A layer of the sum. Its planes must have width x height values.
    void add(const SplitLayer& layer);
    /// The layer that is split; exactly one.
    void add_whole(const SplitLayer& layer);
    /// What split_check.h promises, names excepted. The residual map is filled in only when asked for.
    [[nodiscard]] SplitVerdict verdict(bool with_residual) const;

    /// Of the arrays that one sum keeps, for memory estimates.
    static constexpr std::size_t bytes_per_pixel = 3 * (2 * sizeof(double) + sizeof(float));

  private:
    void note(const SplitLayer& layer, bool whole);
    int width_ = 0;
    double unit_ = 0;  // u
    double spacing_;   // of subnormal numbers, summed over all values of a pixel's component, and what cancelled
    std::array<std::vector<double>, 3> sum_, scale_;
    std::array<std::vector<float>, 3> whole_;
    std::array<std::vector<Open>, 3> open_;  // of sum - whole, [pixel] empty while none is
};

/// Marks the pixels of which a value stands at the largest number of its type; makes `clamped` for the first.
void mark_clamped(std::span<const float> values, StoredType type, std::vector<bool>& clamped);

/// Adds the verdict on rows further down, [first_row, ...), to that on the rows above them.
void add_rows(SplitVerdict& verdict, const SplitVerdict& below, int first_row);

/// One line for a header: "holds; largest relative error 5.8e-08 at (3, 4), bound 1.2e-07; 9 layers".
[[nodiscard]] std::string verdict_attribute(const SplitVerdict& verdict, std::size_t layer_count);

}  // namespace raylex::display
