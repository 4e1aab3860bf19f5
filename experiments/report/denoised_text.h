// What denoising did, as text.
#pragma once

#include <string>
#include <vector>

#include "display/output/denoise/denoised_image.h"

namespace raylex::experiments {

/// One line for each layer: its relative error before and after with the 95 % interval, and the light that the filter
/// removed or added.
std::vector<std::string> denoised_text(const display::DenoisedImage& denoised);

}  // namespace raylex::experiments
