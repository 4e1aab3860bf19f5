// The filter of one tile: weights of pixel pairs, the regression on features, and the estimate of its error.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "display/buffer/pixel_image.h"
#include "display/output/denoise/denoise.h"
#include "display/services/processor.h"

namespace raylex::display {

inline constexpr int search_radius = 7;  ///< of the neighbourhood that a pixel's mean is taken over
inline constexpr int patch_radius = 2;   ///< of the patches that a weight compares
inline constexpr int risk_radius = 2;    ///< of the window over which estimates of risk are averaged
inline constexpr int search_side = 2 * search_radius + 1;
inline constexpr std::size_t searched = std::size_t{search_side} * search_side;  ///< pixels of a neighbourhood

/// A layer in a tile: an estimate of each pixel and of its squared error, the sum of three components.
struct TileEstimate {
    std::array<std::vector<float>, 3> values;
    std::vector<float> risk;
    std::vector<float> shown;  ///< the part of the variance that the removed noise shows, 0 to 1
    std::vector<float> step;   ///< from the noisy pixel (0) to the filtered one (1)
};

/// Works on the tile `kept`, and for averages of risk also on a margin around it.
class TileFilter {
  public:
    TileFilter(const NoisyImage& image, const PixelRegion& kept);

    /// Sets the weights to those of this layer. Returns false if the layer has no noise here, so nothing to filter.
    bool weigh(std::size_t layer);
    /// Applies the weights to a layer. The result is a step from the noisy pixels towards the weighted means: the best
    /// one, or that of `guide`.
    [[nodiscard]] TileEstimate estimate(std::size_t layer, const TileEstimate* guide = nullptr) const;
    /// The noisy pixels of the tile, with their variance as risk.
    [[nodiscard]] TileEstimate noisy(std::size_t layer) const;

  private:
    struct LayerPlanes {
        std::array<std::vector<float>, 3> values, variance;
    };
    [[nodiscard]] std::vector<float> cut(std::span<const float> plane) const;
    [[nodiscard]] std::vector<float> summed(const std::vector<float>& estimated) const;
    RAYLEX_WIDE [[nodiscard]] std::array<std::vector<float>, 3> apply(
        const std::array<std::vector<float>, 3>& planes) const;
    RAYLEX_WIDE void compare_features();
    RAYLEX_WIDE void compare_patches(const LayerPlanes& planes, int dx, int dy);
    RAYLEX_WIDE void set_weights(int dx, int dy, std::size_t offset, int sign);
    RAYLEX_WIDE void normalize();
    void regress();
    RAYLEX_WIDE void regress_row(int y);

    const NoisyImage& image_;
    PixelRegion kept_, estimated_, read_;
    int width_, height_, stride_;  ///< of estimated_; of read_
    std::vector<float> inside_;    ///< 1 for pixels of the image
    std::vector<LayerPlanes> layers_;
    std::vector<std::vector<float>> features_, feature_noise_;
    std::vector<float> feature_weights_, weights_;  ///< [offset][pixel of estimated_]
    std::vector<float> distance_, sums_;            ///< over read_
    std::vector<float> moments_, differences_;      ///< of one row
};

}  // namespace raylex::display
