// An image on an area light, and the distribution of points on one primitive by it.
#pragma once

#include "transport/lights/images/pixel_distribution.h"
#include "transport/lights/images/rgb_image.h"

namespace raylex::transport {

/// The image of an AreaLightSource, shared by all shapes that it lights.
struct EmissionImage {
    RgbImage image;
    double mean = 0;  ///< luminance, over all pixels

    /// Radiance by texture coordinates: v = 1 is the image's top; beyond [0, 1] the border continues (pbrt-v4 format).
    [[nodiscard]] Rgb radiance(Real u, Real v) const { return image.bilinear(u, 1 - v); }
};

/// The point distribution of the light of one primitive. The image's density `points` draws the numbers in [0, 1)^2
/// from which area_points.h makes points. A tenth of them is uniform, so that emission that a cell averages away is
/// still found.
struct EmissionPoints {
    std::int32_t image = -1;  ///< index of the EmissionImage
    PixelDistribution points;
};

}  // namespace raylex::transport
