// Errors between images as people see them: metrics that look at a pixel's surroundings. Those of single values stand
// in error_metrics.h.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace raylex::display {

/// What is compared is what an sRGB monitor shows: linear R G B of Rec. 709 primaries, 1 the brightest.
///
/// `ssim`: Z. Wang, A. Bovik, H. Sheikh, E. Simoncelli, "Image Quality Assessment: From Error Visibility to Structural
/// Similarity", 2004, of the sRGB-encoded luminance of colours clamped to 0..1: Gaussian windows of 11 x 11 pixels and
/// deviation 1.5, K1 = 0.01, K2 = 0.03, L = 1. The mean is over the pixels whose window is inside the image, as in the
/// publication; nearer to the border, and all over an image that is smaller than a window, the part of the window that
/// is inside counts. 1 means alike; its map is 1 - ssim.
///
/// `flip`: P. Andersson, J. Nilsson, T. Akenine-Moeller, M. Oskarsson, K. Astrom, M. Fairchild, "FLIP: A Difference
/// Evaluator for Alternating Images", 2020, of colours clamped to 0..1, seen with 67.02 pixels per degree (a monitor
/// 0.7 m wide with 3840 pixels, 0.7 m away). Beyond the border the image goes on as its last pixel.
///
/// `hdr_flip`: P. Andersson, J. Nilsson, P. Shirley, T. Akenine-Moeller, "Visualizing Errors in Rendered High Dynamic
/// Range Images", 2021: the largest flip of each pixel over n = max(2, ceil(stops)) evenly spaced exposures, from the
/// one that shows the reference's brightest pixel at 0.85 to the one, so many stops away, that shows its median
/// luminance so, through K. Narkowicz's curve of the ACES view (2015). A median below 2^-23 of the brightest counts as
/// that. A black reference has the exposure 0 alone.
enum class ImageMetric : std::uint8_t { ssim, flip, hdr_flip };
inline constexpr std::size_t image_metric_count = 3;

struct ImageMetricInfo {
    ImageMetric metric;
    const char* name;     ///< as options write it: "hdr-flip"
    const char* formula;  ///< in short, with its source
};
/// All of them, in the order of the enumeration.
std::span<const ImageMetricInfo, image_metric_count> image_metrics();
const ImageMetricInfo& info_of(ImageMetric metric);

inline constexpr double flip_pixels_per_degree = 67.0206;  ///< 0.7 m x 3840 pixels / 0.7 m x pi / 180

/// Linear R G B of Rec. 709 primaries, row-major, interleaved; all values finite.
struct LinearImage {
    int width = 0, height = 0;
    std::vector<double> rgb;
};

struct ImageErrors {
    double value = 0;         ///< the metric: the mean, see above
    std::vector<double> map;  ///< of each pixel, 0 for none: 0..1 for flip and hdr_flip, 0..2 for ssim
};

/// The images are of one size, at least 1 x 1.
ImageErrors measure_image(ImageMetric metric, const LinearImage& image, const LinearImage& reference);

}  // namespace raylex::display
