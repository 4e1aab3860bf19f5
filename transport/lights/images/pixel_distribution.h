// Points of the unit square with a density that is constant over each of width x height pixels: rows are chosen first,
// then a pixel of the row.
#pragma once

#include <cstdint>
#include <vector>

#include "transport/math/real.h"
#include "transport/math/vec.h"

namespace raylex::transport {

class PixelDistribution {
  public:
    PixelDistribution() = default;
    /// `weights` is row-major, width x height elements, >= 0; if all are 0, nothing is drawn.
    PixelDistribution(int width, int height, const std::vector<double>& weights);

    struct Drawn {
        std::size_t pixel = 0;
        Vec2 at;           ///< in [0, 1)^2
        Real density = 0;  ///< at `at`; 0: nothing was drawn
    };
    /// Draws a point with u in [0, 1)^2.
    [[nodiscard]] Drawn sample(const Vec2& u) const;
    [[nodiscard]] Real density(std::size_t pixel) const;
    [[nodiscard]] std::size_t pixel_of(const Vec2& at) const;
    [[nodiscard]] Real density_at(const Vec2& at) const { return density(pixel_of(at)); }

  private:
    std::size_t width_ = 0, height_ = 0;
    std::vector<Real> rows_;     // [height + 1] cumulative share of the rows
    std::vector<Real> columns_;  // [height][width + 1] cumulative share within a row
};

}  // namespace raylex::transport
