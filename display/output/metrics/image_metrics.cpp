// The list of metrics, and SSIM; flip.cpp implements FLIP.
#include "display/output/metrics/image_metrics.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "display/output/metrics/flip.h"
#include "display/output/metrics/image_filters.h"
#include "display/services/elementary.h"

namespace raylex::display {

namespace {

constexpr std::array<ImageMetricInfo, image_metric_count> image_metric_table{{
    {ImageMetric::ssim, "ssim",
     "mean((2 ma mb + C1) (2 sab + C2) / ((ma^2 + mb^2 + C1) (sa^2 + sb^2 + C2))), Wang et al. 2004:\n"
     "means m, deviations s in Gaussian windows (11 x 11, 1.5) of the sRGB-encoded luminance, clamped to 0..1;\n"
     "C1 = 0.01^2, C2 = 0.03^2; 1 means equal"},
    {ImageMetric::flip, "flip",
     "mean(Ec^(1 - Ef)), Andersson et al. 2020: Ec the HyAB difference of colours as the eye resolves them, Ef that "
     "of\n"
     "edges and points; sRGB, clamped to 0..1, 67.02 pixels per degree; 0 means equal, 1 is green against blue"},
    {ImageMetric::hdr_flip, "hdr-flip",
     "mean of the largest flip over exposures, Andersson et al. 2021: from the reference's brightest pixel shown at "
     "0.85\n"
     "to its median shown so, about a stop apart, through the ACES curve of Narkowicz"},
}};

double encoded_luminance(const double* rgb) {
    constexpr std::array<double, 3> weights{0.2126, 0.7152, 0.0722};  // ITU-R BT.709
    double luminance = 0;
    for (std::size_t c = 0; c < 3; ++c) luminance += weights[c] * std::clamp(rgb[c], 0.0, 1.0);
    // IEC 61966-2-1
    return luminance <= 0.0031308 ? 12.92 * luminance : 1.055 * elementary::pow(luminance, 1 / 2.4) - 0.055;
}

Plane luminance_plane(const LinearImage& image) {
    Plane plane(image.width, image.height);
    for (std::size_t i = 0; i < plane.size(); ++i) plane.values[i] = encoded_luminance(&image.rgb[3 * i]);
    return plane;
}

Plane product(const Plane& a, const Plane& b) {
    Plane result(a.width, a.height);
    for (std::size_t i = 0; i < a.size(); ++i) result.values[i] = a.values[i] * b.values[i];
    return result;
}

ImageErrors measure_ssim(const LinearImage& image, const LinearImage& reference) {
    constexpr int radius = 5;
    constexpr double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;
    const Kernel window = normalised(gaussian(1.5, radius));
    const Plane a = luminance_plane(image), b = luminance_plane(reference);
    Plane ones(a.width, a.height);
    std::fill(ones.values.begin(), ones.values.end(), 1.0);
    const auto windowed = [&window](const Plane& plane) { return filtered(plane, window, window, Border::nothing); };
    // The fraction of each window that is inside the image.
    const Plane inside = windowed(ones);
    const Plane sum_a = windowed(a), sum_b = windowed(b), sum_aa = windowed(product(a, a)),
                sum_bb = windowed(product(b, b)), sum_ab = windowed(product(a, b));
    ImageErrors result;
    result.map.resize(a.size());
    const bool whole = a.width > 2 * radius && a.height > 2 * radius;
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const double share = inside.values[i], ma = sum_a.values[i] / share, mb = sum_b.values[i] / share;
        const double saa = std::max(0.0, sum_aa.values[i] / share - ma * ma),
                     sbb = std::max(0.0, sum_bb.values[i] / share - mb * mb), sab = sum_ab.values[i] / share - ma * mb;
        const double ssim = (2 * ma * mb + c1) * (2 * sab + c2) / ((ma * ma + mb * mb + c1) * (saa + sbb + c2));
        result.map[i] = 1 - ssim;
        const int x = static_cast<int>(i) % a.width, y = static_cast<int>(i) / a.width;
        const bool complete = x >= radius && y >= radius && x < a.width - radius && y < a.height - radius;
        if (whole && !complete) continue;
        sum += ssim;
        count += 1;
    }
    result.value = sum / count;
    return result;
}

}  // namespace

std::span<const ImageMetricInfo, image_metric_count> image_metrics() {
    return image_metric_table;
}

const ImageMetricInfo& info_of(ImageMetric metric) {
    return image_metric_table[static_cast<std::size_t>(metric)];
}

ImageErrors measure_image(ImageMetric metric, const LinearImage& image, const LinearImage& reference) {
    switch (metric) {
        case ImageMetric::ssim:
            return measure_ssim(image, reference);
        case ImageMetric::flip:
            return measure_flip(image, reference);
        case ImageMetric::hdr_flip:
            return measure_hdr_flip(image, reference);
    }
    return {};
}

}  // namespace raylex::display
