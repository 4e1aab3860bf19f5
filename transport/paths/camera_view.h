// The camera and the image that it fills, as subpaths see them.
#pragma once

#include <algorithm>

#include "transport/cameras/camera.h"
#include "transport/math/vec.h"

namespace raylex::transport {

/// A rectangle of the raster, in pixels.
struct RasterArea {
    Vec2 corner, size;
    double share = 1;  ///< its area over the image's
};

struct CameraView {
    const Camera* camera = nullptr;
    int width = 0, height = 0;  ///< of the image, in pixels
    Vec2 filter_radius;  ///< in pixels; a light sample up to this distance from a pixel's centre adds to the pixel

    /// Density per area with which a camera ray through a raster position drawn uniformly over the image meets a point.
    /// `importance`: raster area per area at the point across the ray. `cosine`: |cos| at the point.
    [[nodiscard]] double density(Real importance, Real cosine) const {
        return static_cast<double>(importance) * static_cast<double>(cosine) /
               (static_cast<double>(width) * static_cast<double>(height));
    }
    /// The area in which light adds to the image: the image, extended on each side by the part of the filter radius
    /// that exceeds half a pixel.
    [[nodiscard]] RasterArea reached() const {
        const Vec2 reach{std::max(filter_radius.x - Real(0.5), Real(0)),
                         std::max(filter_radius.y - Real(0.5), Real(0))};
        const Vec2 size{static_cast<Real>(width) + 2 * reach.x, static_cast<Real>(height) + 2 * reach.y};
        return {{-reach.x, -reach.y},
                size,
                static_cast<double>(size.x) * static_cast<double>(size.y) /
                    (static_cast<double>(width) * static_cast<double>(height))};
    }
};

}  // namespace raylex::transport
