// Errors of an image against a reference, over the whole image or a region of it. The formulas are those of `raylex
// compare` (display/output/metrics/error_metrics.h), over the three components of every pixel together.
#pragma once

#include <cstdint>
#include <vector>

#include "display/output/metrics/error_metrics.h"
#include "experiments/study/results.h"

namespace raylex::experiments {

/// Pixels y * width + x of a region, ascending. Errors: a crop outside the image or empty, a mask that cannot be read,
/// is of another size, or is black everywhere.
Result<std::vector<std::uint32_t>> region_pixels(const Region& region, int width, int height);

/// The values of these pixels, component by component; all pixels when there are none.
std::vector<double> values_of(const PixelArray& array, const std::vector<std::uint32_t>& pixels);

/// Every metric over `pixels`, all when empty. The arrays are of one shape.
display::ErrorMeasures measure_errors(const PixelArray& image, const PixelArray& reference,
                                      const std::vector<std::uint32_t>& pixels = {});

/// The variance of the mean of every value, from the sums of squared deviations `m2` and the samples per pixel n:
/// m2 / (n (n - 1)); infinite where n is below 2.
PixelArray variance_of_mean(const PixelArray& m2, const PixelArray& samples);

/// The relative error that studies speak of ("1 %"): the root of relmse-mean, 0 where noise subtraction leaves it below
/// 0.
double relative_error(double relmse_mean);

}  // namespace raylex::experiments
