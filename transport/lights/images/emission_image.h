// An image on an area light, and how points of one primitive are drawn by it.
#pragma once

#include "transport/lights/images/pixel_distribution.h"
#include "transport/lights/images/rgb_image.h"

namespace raylex::transport {

/// Of an AreaLightSource, shared by all that it lights.
struct EmissionImage {
    RgbImage image;
    double mean = 0;  ///< luminance, over all pixels

    /// By texture coordinates: v = 1 is the image's top, beyond [0, 1] the border goes on (pbrt-v4 format).
    [[nodiscard]] Rgb radiance(Real u, Real v) const { return image.bilinear(u, 1 - v); }
};

/// Beside the light of one primitive. The numbers in [0, 1)^2 from which area_points.h makes points of it are drawn by
/// the image: `points` has their density. A tenth of them ignores it, so that what a cell averages away stays found.
struct EmissionPoints {
    std::int32_t image = -1;  ///< index of the EmissionImage
    PixelDistribution points;
};

}  // namespace raylex::transport
