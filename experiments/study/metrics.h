// Errors of an image against a reference, over the whole image or a region. The formulas are those of `raylex compare`
// (display/output/metrics/error_metrics.h), over all three components of every pixel.
#pragma once

#include <cstdint>
#include <vector>

#include "display/output/metrics/error_metrics.h"
#include "experiments/study/results.h"

namespace raylex::experiments {

/// Returns the pixels y * width + x of a region in ascending order. Errors: a crop that is empty or outside the image;
/// a mask that cannot be read, has another size, or is black.
Result<std::vector<std::uint32_t>> region_pixels(const Region& region, int width, int height);

/// Returns the values of these pixels, by component; of all pixels if the list is empty.
std::vector<double> values_of(const PixelArray& array, const std::vector<std::uint32_t>& pixels);

/// Returns every metric over `pixels`, or over all if it is empty. The arrays must have the same shape.
display::ErrorMeasures measure_errors(const PixelArray& image, const PixelArray& reference,
                                      const std::vector<std::uint32_t>& pixels = {});

/// Returns the variance of the mean of every value, from the sums of squared deviations `m2` and the samples per pixel
/// n: m2 / (n (n - 1)); infinite if n is below 2.
PixelArray variance_of_mean(const PixelArray& m2, const PixelArray& samples);

/// Returns the relative error of studies ("1 %"): the root of relmse-mean, or 0 if noise subtraction makes it negative.
double relative_error(double relmse_mean);

}  // namespace raylex::experiments
