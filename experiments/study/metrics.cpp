#include "experiments/study/metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "display/output/reader/exr_reader.h"

namespace raylex::experiments {
namespace {

Error region_error(const Region& region, const std::string& message) {
    Error error;
    error.file = region.mask_file;
    error.message = "region '" + region.name + "': " + message;
    return error;
}

std::string size_of(int width, int height) {
    return std::to_string(width) + " x " + std::to_string(height);
}

}  // namespace

Result<std::vector<std::uint32_t>> region_pixels(const Region& region, int width, int height) {
    std::array<int, 4> crop = region.crop;
    if (crop == std::array<int, 4>{}) crop = {0, 0, width, height};
    if (crop[0] < 0 || crop[1] < 0 || crop[2] > width || crop[3] > height || crop[0] >= crop[2] || crop[1] >= crop[3])
        return region_error(region, "the crop [" + std::to_string(crop[0]) + ", " + std::to_string(crop[1]) + ", " +
                                        std::to_string(crop[2]) + ", " + std::to_string(crop[3]) +
                                        "] is not a part of an image of " + size_of(width, height) +
                                        " pixels; expected x0 < x1 and y0 < y1 inside it");
    std::vector<float> mask;
    if (!region.mask_file.empty()) {
        Result<display::ExrImage> image = display::read_exr(region.mask_file);
        if (!image) return std::move(image).error();
        if (image->width != width || image->height != height)
            return region_error(region, "the mask has " + size_of(image->width, image->height) + " pixels; expected " +
                                            size_of(width, height));
        mask.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0.0f);
        for (const display::ImageLayer& layer : image->layers)
            for (const display::ImagePlane& plane : layer.planes)
                if (plane.name != "A")
                    for (std::size_t i = 0; i < mask.size(); ++i)
                        mask[i] = std::max(mask[i], std::abs(plane.values[i]));
    }
    std::vector<std::uint32_t> pixels;
    for (int y = crop[1]; y < crop[3]; ++y)
        for (int x = crop[0]; x < crop[2]; ++x) {
            const auto pixel = static_cast<std::uint32_t>(y) * static_cast<std::uint32_t>(width) +
                               static_cast<std::uint32_t>(x);  // up to 2^32 - 1
            if (mask.empty() || mask[pixel] > 0) pixels.push_back(pixel);
        }
    if (pixels.empty()) return region_error(region, "all pixels of the mask inside the crop are 0");
    return pixels;
}

std::vector<double> values_of(const PixelArray& array, const std::vector<std::uint32_t>& pixels) {
    if (pixels.empty()) return array.values;
    std::vector<double> values;
    values.reserve(pixels.size() * array.components);
    for (const std::uint32_t pixel : pixels) {
        const auto first = array.values.begin() + static_cast<std::ptrdiff_t>(pixel * array.components);
        values.insert(values.end(), first, first + static_cast<std::ptrdiff_t>(array.components));
    }
    return values;
}

display::ErrorMeasures measure_errors(const PixelArray& image, const PixelArray& reference,
                                      const std::vector<std::uint32_t>& pixels) {
    if (pixels.empty()) return display::measure_errors(image.values, reference.values);
    return display::measure_errors(values_of(image, pixels), values_of(reference, pixels));
}

PixelArray variance_of_mean(const PixelArray& m2, const PixelArray& samples) {
    PixelArray variance = m2;
    for (std::size_t pixel = 0; pixel < samples.values.size(); ++pixel) {
        const double n = samples.values[pixel];
        for (std::size_t c = 0; c < m2.components; ++c) {
            double& value = variance.values[pixel * m2.components + c];
            value = n > 1 ? value / (n * (n - 1)) : std::numeric_limits<double>::infinity();
        }
    }
    return variance;
}

double relative_error(double relmse_mean) {
    return std::sqrt(std::max(0.0, relmse_mean));
}

}  // namespace raylex::experiments
