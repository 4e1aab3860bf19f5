// The arithmetic of a split check, taking its layers in one after another: writers feed it what they are about to
// store, readers what they found.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "display/output/split_check.h"

namespace raylex::display {

/// Three components of a layer as stored; a layer of a single plane shows it three times.
struct SplitLayer {
    std::array<std::span<const float>, 3> planes;
    std::array<StoredType, 3> types{};
};

class SplitSum {
  public:
    SplitSum(int width, int height);
    /// A layer of the sum. Its planes must have width x height values.
    void add(const SplitLayer& layer);
    /// The layer that is split; exactly one.
    void add_whole(const SplitLayer& layer);
    /// What split_check.h promises, names excepted. The residual map is filled in only when asked for.
    [[nodiscard]] SplitVerdict verdict(bool with_residual) const;

    /// Of the arrays that one sum keeps, for memory estimates.
    static constexpr std::size_t bytes_per_pixel = 3 * (2 * sizeof(double) + sizeof(float));

  private:
    void note_types(const SplitLayer& layer);
    int width_ = 0;
    double unit_ = 0;     // u
    double spacing_ = 0;  // of subnormal numbers, summed over all values of a pixel's component
    std::array<std::vector<double>, 3> sum_, scale_;
    std::array<std::vector<float>, 3> whole_;
};

/// One line for a header: "holds; largest relative error 5.8e-08 at (3, 4), bound 1.2e-07; 9 layers".
[[nodiscard]] std::string verdict_attribute(const SplitVerdict& verdict, std::size_t layer_count);

}  // namespace raylex::display
