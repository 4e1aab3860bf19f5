// Where a split does not hold, as a picture.
#include <algorithm>
#include <cmath>

#include "display/output/color_manager.h"
#include "display/output/split_check.h"
#include "display/output/split_sum.h"

namespace raylex::display {

namespace {

// Anchors of the scale in Oklab (B. Ottosson 2020): lightness rises evenly, so that the order is seen at once and also
// without colour vision; the hue goes from blue over violet (within the bound) and red to yellow.
struct Anchor {
    double at, lightness, a, b;
};
constexpr Anchor scale[] = {{0.00, 0.12, 0.00, -0.06}, {0.25, 0.30, 0.03, -0.15}, {0.49, 0.42, 0.12, -0.12},
                            {0.51, 0.56, 0.19, 0.06},  {0.75, 0.74, 0.10, 0.14},  {1.00, 0.96, -0.03, 0.10}};

unsigned char encode(double linear) {
    const double clipped = std::clamp(linear, 0.0, 1.0);
    const double value =
        clipped <= 0.0031308 ? 12.92 * clipped : 1.055 * std::pow(clipped, 1 / 2.4) - 0.055;  // IEC 61966-2-1
    return static_cast<unsigned char>(std::lround(255 * value));
}

std::array<unsigned char, 3> color_at(double position) {
    std::size_t next = 1;
    while (next + 1 < std::size(scale) && scale[next].at < position) ++next;
    const Anchor &p = scale[next - 1], &q = scale[next];
    const double t = std::clamp((position - p.at) / (q.at - p.at), 0.0, 1.0);
    const double lightness = std::lerp(p.lightness, q.lightness, t), a = std::lerp(p.a, q.a, t),
                 b = std::lerp(p.b, q.b, t);
    // Oklab to linear sRGB, matrices of the publication.
    const auto cube = [](double x) { return x * x * x; };
    const double l = cube(lightness + 0.3963377774 * a + 0.2158037573 * b),
                 m = cube(lightness - 0.1055613458 * a - 0.0638541728 * b),
                 s = cube(lightness - 0.0894841775 * a - 1.2914855480 * b);
    return {encode(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
            encode(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
            encode(-0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s)};
}

// 0 .. 0.49 within the bound (ten powers of two below it), 0.51 .. 1 from the bound to 1.
double position_of(double residual, double bound) {
    if (residual <= bound) return 0.49 * std::clamp(1 + std::log2(residual / bound) / 10, 0.0, 1.0);
    return 0.51 + 0.49 * std::clamp(std::log2(residual / bound) / -std::log2(bound), 0.0, 1.0);
}

}  // namespace

Status write_residual_png(const std::string& path, const SplitVerdict& verdict, int width, int height) {
    if (width <= 0 || height <= 0 ||
        verdict.residual.size() != static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {
        Error error;
        error.file = path;
        error.message = "the verdict is of " + std::to_string(verdict.residual.size()) + " pixels; expected " +
                        std::to_string(width) + " x " + std::to_string(height);
        return error;
    }
    const double limit = residual_limit(verdict.bound, verdict.allowance);
    std::vector<unsigned char> rgb;
    rgb.reserve(verdict.residual.size() * 3);
    for (const float residual : verdict.residual) {
        const std::array<unsigned char, 3> color = !std::isfinite(residual) ? std::array<unsigned char, 3>{0, 255, 255}
                                                   : residual == 0          ? std::array<unsigned char, 3>{0, 0, 0}
                                                                            : color_at(position_of(residual, limit));
        rgb.insert(rgb.end(), color.begin(), color.end());
    }
    return write_png(path, width, height, rgb);
}

}  // namespace raylex::display
