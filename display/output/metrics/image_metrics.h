// Perceptual errors between images: metrics that use a neighbourhood of each pixel. error_metrics.h has the metrics of
// single values.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace raylex::display {

/// They compare the images as an sRGB monitor shows them: linear R G B with Rec. 709 primaries, 1 is the brightest.
///
/// `ssim`: Z. Wang, A. Bovik, H. Sheikh, E. Simoncelli, "Image Quality Assessment: From Error Visibility to Structural
/// Similarity", 2004, of the sRGB-encoded luminance of colours clamped to 0..1: Gaussian windows of 11 x 11 pixels and
/// deviation 1.5, K1 = 0.01, K2 = 0.03, L = 1. As in the publication, the mean is over pixels whose window is inside
/// the image. Closer to the border, and everywhere in an image smaller than a window, only the inner part of the window
/// counts. 1 means identical; the map is 1 - ssim.
///
/// `flip`: P. Andersson, J. Nilsson, T. Akenine-Moeller, M. Oskarsson, K. Astrom, M. Fairchild, "FLIP: A Difference
/// Evaluator for Alternating Images", 2020, of colours clamped to 0..1, seen with 67.02 pixels per degree (a monitor
/// 0.7 m wide with 3840 pixels, 0.7 m away). Beyond the border the last pixel repeats.
///
/// `hdr_flip`: P. Andersson, J. Nilsson, P. Shirley, T. Akenine-Moeller, "Visualizing Errors in Rendered High Dynamic
/// Range Images", 2021: for each pixel the largest flip over n = max(2, ceil(stops)) evenly spaced exposures, shown
/// through K. Narkowicz's curve of the ACES view (2015). The first exposure shows the reference's brightest pixel at
/// 0.85, and the last one, `stops` away, its median luminance. A median below 2^-23 of the brightest pixel is raised to
/// that. A black reference has only the exposure 0.
enum class ImageMetric : std::uint8_t { ssim, flip, hdr_flip };
inline constexpr std::size_t image_metric_count = 3;

struct ImageMetricInfo {
    ImageMetric metric;
    const char* name;     ///< name in options: "hdr-flip"
    const char* formula;  ///< short, with its source
};
/// All metrics, in the order of the enumeration.
std::span<const ImageMetricInfo, image_metric_count> image_metrics();
const ImageMetricInfo& info_of(ImageMetric metric);

inline constexpr double flip_pixels_per_degree = 67.0206;  ///< 0.7 m x 3840 pixels / 0.7 m x pi / 180

/// Linear R G B with Rec. 709 primaries, row-major, interleaved; all values are finite.
struct LinearImage {
    int width = 0, height = 0;
    std::vector<double> rgb;
};

struct ImageErrors {
    double value = 0;         ///< the metric: the mean, see above
    std::vector<double> map;  ///< error of each pixel, 0 for none: 0..1 for flip and hdr_flip, 0..2 for ssim
};

/// Measures the metric. Both images have the same size, at least 1 x 1.
ImageErrors measure_image(ImageMetric metric, const LinearImage& image, const LinearImage& reference);

}  // namespace raylex::display
