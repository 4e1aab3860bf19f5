// How a primitive of an area light draws points by the image that it shows.
#pragma once

#include "transport/embree/embree_scene.h"
#include "transport/lights/images/emission_image.h"
#include "transport/lights/light.h"

namespace raylex::transport {

struct PrimitiveImage {
    PixelDistribution points;   ///< over the numbers in [0, 1)^2 that area_points.h makes points of
    double mean_luminance = 0;  ///< of the image, over the primitive's area
};

/// `light` says kind and primitive. The cells are about as fine as the image there, 256 x 256 at most, and all cells of
/// a mesh together 2^20 at most, but one for each primitive.
[[nodiscard]] PrimitiveImage image_on_primitive(const Light& light, const ShapeGeometry& shape,
                                                const EmissionImage& shown);

}  // namespace raylex::transport
