// Denoises layers of light so that they still sum. It uses statistics of the render only; nothing is trained.
//
// Filter. Each pixel becomes a weighted mean of its neighbourhood. A weight compares patches of the layer relative to
// their noise (non-local means: Rousselle, Knaus, Zwicker, "Adaptive rendering with non-local means filtering", 2012)
// and pixels of the features (albedo, normal) relative to theirs (Rousselle, Manzi, Zwicker, "Robust denoising using
// feature and color information", 2013). For the beauty's weights, a regression on the features within the
// neighbourhood then corrects the mean to first order (Bitterli et al., "Nonlinearly weighted first-order regression
// for denoising Monte Carlo renderings", 2016).
//
// Layers. Each layer has two candidates: the filter of the beauty, which serves every layer, and its own. Stein's
// unbiased risk estimate gives the error of each and the best step from the noisy pixel towards it. Least squares, with
// the estimated errors as weights, then moves all layers and their wholes to the nearest pixel in which every sum
// holds. Without declared sums, the filter of the beauty and its steps serve all layers, so any sum of layers stays.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace raylex::display {

/// A layer of light: three planes of width x height values, and the variance of each.
struct NoisyLayer {
    std::array<std::vector<float>, 3> values;
    std::array<std::vector<float>, 3> variance;
};

/// One plane of a feature, such as the red of the albedo, and its variance. An empty variance is 0.
struct FilterFeature {
    std::vector<float> values, variance;
};

/// Layers that sum to another. The numbers count NoisyImage::layers.
struct LayerIdentity {
    std::size_t of = 0;
    std::vector<std::size_t> layers;
};

struct NoisyImage {
    int width = 0, height = 0;
    std::vector<NoisyLayer> layers;  ///< the first one guides the filter of all: the beauty
    std::vector<FilterFeature> features;
    std::vector<LayerIdentity> sums;
};

/// The estimate of a layer's error over the whole image.
struct LayerError {
    double before = 0, after = 0;       ///< mean squared error of a value, estimated
    double least = 0, most = 0;         ///< the interval of 95 % for `after`
    double light = 0, light_after = 0;  ///< sum of all values before and after
};

/// Replaces the values of every layer by denoised ones, and its first plane of variance by the estimated squared error
/// of a pixel, the mean of its three components. Frees the other two. Identical bits for any number of threads.
std::vector<LayerError> denoise(NoisyImage& image, int threads);

}  // namespace raylex::display
