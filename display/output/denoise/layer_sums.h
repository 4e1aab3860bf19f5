// Moves denoised layers to the nearest values that sum.
#pragma once

#include <span>
#include <vector>

#include "display/output/denoise/denoise.h"

namespace raylex::display {

class LayerSums {
  public:
    LayerSums(std::span<const LayerIdentity> sums, std::size_t layers);

    /// One component of one pixel in every layer: the noisy values, which sum, and the denoised values with their risk
    /// (expected squared error). Changes `denoised` by the least squares of changes over risks so that every sum holds.
    /// No layer becomes negative that was not.
    void make_sum(std::span<const double> noisy, std::span<const double> risk, std::span<double> denoised);
    /// The risk of each layer after make_sum().
    void reduce_risk(std::span<const double> risk, std::span<double> reduced);

  private:
    void factor(std::span<const double> risk);
    void solve(std::span<double> rhs) const;
    void project(std::span<const double> risk, std::span<double> values);
    [[nodiscard]] double residual(std::size_t sum, std::span<const double> values) const;

    std::span<const LayerIdentity> sums_;
    std::vector<std::vector<double>> signs_;  ///< [sum][layer]: 1 for its terms, -1 for the whole, else 0
    std::vector<double> matrix_, multipliers_, free_;
};

}  // namespace raylex::display
