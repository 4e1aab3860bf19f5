// The pixels that a raster splat contributes to, and their weights.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "display/buffer/pixel_filter.h"
#include "display/services/samples/sample_table.h"

namespace raylex::display {

/// The first and last pixel that a splat reaches along one axis.
struct RasterFootprint {
    int first, last;

    RasterFootprint(float position, float radius, int size)
        : first(std::max(0, static_cast<int>(std::floor(position - radius - 0.5f)))),
          last(std::min(size - 1, static_cast<int>(std::ceil(position + radius - 0.5f)))) {}
    /// The distance from a pixel's centre. A splat exactly on the edge of a kernel belongs to the pixel on its right,
    /// so that a box filter loses none: float positions do lie on edges sometimes.
    static float offset(float position, int pixel, float radius) {
        const float from_centre = position - (static_cast<float>(pixel) + 0.5f);
        return from_centre == -radius ? std::nextafter(from_centre, 0.0f) : from_centre;
    }
};

/// Calls visit(pixel, weight) for every pixel of an image that `splat` contributes to; the weight includes the splat's
/// own.
template <class Visit>
void for_each_reached(const PixelFilter& kernel, const CameraRow& splat, int width, int height, Visit visit) {
    const RasterFootprint across(splat.screen_x, kernel.radius_x(), width),
        down(splat.screen_y, kernel.radius_y(), height);
    for (int y = down.first; y <= down.last; ++y)
        for (int x = across.first; x <= across.last; ++x) {
            const double weight =
                static_cast<double>(kernel.evaluate(RasterFootprint::offset(splat.screen_x, x, kernel.radius_x()),
                                                    RasterFootprint::offset(splat.screen_y, y, kernel.radius_y()))) *
                static_cast<double>(splat.filter_weight);
            if (weight != 0)
                visit(static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x),
                      weight);
        }
}

}  // namespace raylex::display
