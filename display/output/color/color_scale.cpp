#include "display/output/color/color_scale.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "display/services/elementary.h"

namespace raylex::display {

namespace {

unsigned char encode(double linear) {
    const double clipped = std::clamp(linear, 0.0, 1.0);
    const double value =
        clipped <= 0.0031308 ? 12.92 * clipped : 1.055 * elementary::pow(clipped, 1 / 2.4) - 0.055;  // IEC 61966-2-1
    return static_cast<unsigned char>(std::lround(255 * value));
}

}  // namespace

std::array<unsigned char, 3> scale_color(std::span<const ScaleAnchor> scale, double position) {
    std::size_t next = 1;
    while (next + 1 < scale.size() && scale[next].at < position) ++next;
    const ScaleAnchor &p = scale[next - 1], &q = scale[next];
    const double t = std::clamp((position - p.at) / (q.at - p.at), 0.0, 1.0);
    const double lightness = std::lerp(p.lightness, q.lightness, t), a = std::lerp(p.a, q.a, t),
                 b = std::lerp(p.b, q.b, t);
    // Oklab to linear sRGB, with the matrices of the publication.
    const auto cube = [](double x) { return x * x * x; };
    const double l = cube(lightness + 0.3963377774 * a + 0.2158037573 * b),
                 m = cube(lightness - 0.1055613458 * a - 0.0638541728 * b),
                 s = cube(lightness - 0.0894841775 * a - 1.2914855480 * b);
    return {encode(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
            encode(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
            encode(-0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s)};
}

}  // namespace raylex::display
