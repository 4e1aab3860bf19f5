// The camera and the image that it fills, as subpaths see them.
#pragma once

#include "transport/cameras/camera.h"
#include "transport/math/vec.h"

namespace raylex::transport {

struct CameraView {
    const Camera* camera = nullptr;
    int width = 0, height = 0;  ///< of the image, in pixels
    Vec2 filter_radius;         ///< light up to this distance from the image counts, in pixels

    /// Density per area with which a camera ray through a raster position drawn uniformly over the image meets a point.
    /// `importance`: raster area per area at the point across the ray. `cosine`: |cos| at the point.
    [[nodiscard]] double density(Real importance, Real cosine) const {
        return static_cast<double>(importance) * static_cast<double>(cosine) /
               (static_cast<double>(width) * static_cast<double>(height));
    }
};

}  // namespace raylex::transport
