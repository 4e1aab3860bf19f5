// Collects what a compositor sees when a layer is rebuilt from others: light that is missing or counted twice, with the
// layer that explains it, and light that a colour of 0 loses.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "display/output/splits/layer_arithmetic.h"
#include "display/output/splits/split_sum.h"

namespace raylex::display {

class RebuildTally {
  public:
    RebuildTally(const ExrImage& image, const ImageLayer& of, const LayerSum& sum);
    /// Adds the pixels [first, first + errors.size()).
    void add(std::size_t first, std::span<const std::array<SplitError, 3>> errors);
    [[nodiscard]] Rebuild finish() { return std::move(rebuild_); }

  private:
    void add(std::size_t pixel, std::size_t c, double difference);

    std::size_t width_, pixels_;
    std::vector<const ImageLayer*> spare_, terms_, factors_;  ///< not in the sum; in the sum; factors of its products
    std::vector<std::array<const ImagePlane*, 3>> spare_planes_, term_planes_;
    Rebuild rebuild_;
};

}  // namespace raylex::display
