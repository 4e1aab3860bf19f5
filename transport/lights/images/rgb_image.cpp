#include "transport/lights/images/rgb_image.h"

#include <algorithm>
#include <cmath>

namespace raylex::transport {
namespace {

struct Four {
    int x, y;
    Real across, down;
};

/// The pixel whose centre is above and left of a point, and the position of the point between it and the next.
Four four_around(Real x, Real y, const RgbImage& image) {
    const Real px = x * static_cast<Real>(image.width) - Real(0.5),
               py = y * static_cast<Real>(image.height) - Real(0.5);
    const Real fx = std::floor(px), fy = std::floor(py);
    return {static_cast<int>(fx), static_cast<int>(fy), px - fx, py - fy};
}

template <class Fetch>
Rgb interpolate(const Four& f, Fetch fetch) {
    return (fetch(f.x, f.y) * (1 - f.across) + fetch(f.x + 1, f.y) * f.across) * (1 - f.down) +
           (fetch(f.x, f.y + 1) * (1 - f.across) + fetch(f.x + 1, f.y + 1) * f.across) * f.down;
}

}  // namespace

Rgb RgbImage::bilinear(Real x, Real y) const {
    // Texture coordinates are arbitrary, and the range of int is limited.
    x = std::clamp(x, Real(0), Real(1));
    y = std::clamp(y, Real(0), Real(1));
    return interpolate(four_around(x, y, *this),
                       [this](int i, int j) { return at(std::clamp(i, 0, width - 1), std::clamp(j, 0, height - 1)); });
}

double RgbImage::mean_luminance() const {
    double sum = 0;
    for (const Rgb& pixel : pixels) sum += luminance(pixel);
    return pixels.empty() ? 0 : sum / static_cast<double>(pixels.size());
}

Rgb octahedral_bilinear(const RgbImage& image, const Vec2& at) {
    const int n = image.width;
    return interpolate(four_around(at.x, at.y, image), [&](int x, int y) {
        // Across an edge the sphere continues at the point mirrored at the edge's middle.
        if (x < 0 || x >= n) {
            x = x < 0 ? -x - 1 : 2 * n - 1 - x;
            y = n - 1 - y;
        }
        if (y < 0 || y >= n) {
            y = y < 0 ? -y - 1 : 2 * n - 1 - y;
            x = n - 1 - x;
        }
        return image.at(std::clamp(x, 0, n - 1), std::clamp(y, 0, n - 1));
    });
}

}  // namespace raylex::transport
