// Draws points on a primitive of an area light by the image that it emits.
#pragma once

#include "transport/embree/embree_scene.h"
#include "transport/lights/images/emission_image.h"
#include "transport/lights/light.h"

namespace raylex::transport {

struct PrimitiveImage {
    PixelDistribution points;   ///< over the numbers in [0, 1)^2 from which area_points.h makes points
    double mean_luminance = 0;  ///< of the image, over the primitive's area
};

/// `light` gives the kind and the primitive. Cells are about as fine as the image, with at most 256 x 256 per
/// primitive, and at most 2^20 for a whole mesh, but at least one per primitive.
[[nodiscard]] PrimitiveImage image_on_primitive(const Light& light, const ShapeGeometry& shape,
                                                const EmissionImage& shown);

}  // namespace raylex::transport
