// FLIP and HDR-FLIP; image_metrics.h cites the publications.
#pragma once

#include "display/output/metrics/image_metrics.h"

namespace raylex::display {

ImageErrors measure_flip(const LinearImage& image, const LinearImage& reference);
ImageErrors measure_hdr_flip(const LinearImage& image, const LinearImage& reference);

}  // namespace raylex::display
