// The arithmetic of a split check. It takes layers one by one: writers pass what they are about to store, readers what
// they read.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "display/output/splits/split_check.h"

namespace raylex::display {

/// The three components of a layer as stored; a layer with a single plane has it three times.
struct SplitLayer {
    std::array<std::span<const float>, 3> planes;
    std::array<StoredType, 3> types{};
};

/// The directions in which the true value can be beyond the stored one, which is the largest number of its type.
using Open = std::uint8_t;
inline constexpr Open open_above = 1, open_below = 2;
[[nodiscard]] inline Open open_of(double value, double largest) {
    return value == largest ? open_above : value == -largest ? open_below : Open{0};
}
[[nodiscard]] inline Open negated(Open open) {
    return static_cast<Open>((open & open_above) << 1 | (open & open_below) >> 1);
}

/// The error of one component of one pixel.
struct SplitError {
    double absolute = 0;  ///< |sum - of|
    double scale = 0;     ///< sum of |terms| + |of|
    double rounding = 0;  ///< error that rounding explains
    double allowed = 0;   ///< error that is allowed in total, >= rounding
    double sum = 0, whole = 0;
    bool negative = false;  ///< some value of the pixel is negative
    Open open = 0;          ///< directions in which the true sum - of can be larger
};

/// Sets the answer from the counts of pixels.
void conclude(SplitResult& result);
/// The value in a residual map that separates allowed from exceeding pixels: bound + allowance.relative, at most 1/2.
[[nodiscard]] double residual_limit(double bound, const Allowance& allowance);

/// Collects pixels, in any order, and computes the result.
class ResultTally {
  public:
    /// `unit`: the largest relative rounding error.
    ResultTally(int width, std::size_t pixels, double unit, const Allowance& allowance, bool with_residual);
    /// `clamped`: see SplitResult::clamped.
    void add(std::size_t pixel, std::array<SplitError, 3> components, bool clamped = false);
    [[nodiscard]] SplitResult finish();

  private:
    int width_;
    double limit_;
    SplitResult result_;
};

class SplitSum {
  public:
    /// `cancelled`: see SumRules::cancelled.
    SplitSum(int width, int height, double cancelled = 0);
    /// Adds a layer of the sum. Its planes must have width x height values.
    void add(const SplitLayer& layer);
    /// Adds the layer that is split; exactly once.
    void add_whole(const SplitLayer& layer);
    /// The result as split_check.h defines it, without names. The residual map is filled only if requested.
    [[nodiscard]] SplitResult result(bool with_residual) const;

    /// Memory of the arrays of one sum, for memory estimates.
    static constexpr std::size_t bytes_per_pixel = 3 * (2 * sizeof(double) + sizeof(float));

  private:
    void note(const SplitLayer& layer, bool whole);
    int width_ = 0;
    double unit_ = 0;  // u
    double spacing_;   // of subnormal numbers, summed over all values of a pixel's component, plus the error of
                       // cancelled samples
    std::array<std::vector<double>, 3> sum_, scale_;
    std::array<std::vector<float>, 3> whole_;
    std::array<std::vector<Open>, 3> open_;  // of sum - whole: [pixel], empty while there is none
};

/// Marks pixels with a value at the largest number of their type; allocates `clamped` at the first one.
void mark_clamped(std::span<const float> values, StoredType type, std::vector<bool>& clamped);

/// Adds the part of a result for lower rows.
void add_rows(Rebuild& rebuild, const Rebuild& below, int first_row, std::size_t pixels, std::size_t pixels_below);
/// Adds the result for lower rows, [first_row, ...), to the result for the rows above them.
void add_rows(SplitResult& result, const SplitResult& below, int first_row);

/// One line for a header: "holds; largest relative error 5.8e-08 at (3, 4), bound 1.2e-07; 9 layers".
[[nodiscard]] std::string result_attribute(const SplitResult& result, std::size_t layer_count);

}  // namespace raylex::display
