// Draws the error of a split as a picture.
#include <algorithm>
#include <cmath>

#include "display/output/color/color_manager.h"
#include "display/output/color/color_scale.h"
#include "display/output/splits/split_check.h"
#include "display/output/splits/split_sum.h"
#include "display/services/elementary.h"
#include "display/services/parameters.h"

namespace raylex::display {

namespace {

// The hue goes from blue over violet (within the bound) and red to yellow.
constexpr ScaleAnchor anchors[] = {{0.00, 0.12, 0.00, -0.06}, {0.25, 0.30, 0.03, -0.15}, {0.49, 0.42, 0.12, -0.12},
                                   {0.51, 0.56, 0.19, 0.06},  {0.75, 0.74, 0.10, 0.14},  {1.00, 0.96, -0.03, 0.10}};

// Maps residuals within the bound to 0 .. 0.49 (ten powers of two below it), and residuals above it to 0.51 .. 1.
double position_of(double residual, double bound) {
    if (residual <= bound) return 0.49 * std::clamp(1 + elementary::log2(residual / bound) / 10, 0.0, 1.0);
    return 0.51 + 0.49 * std::clamp(elementary::log2(residual / bound) / -elementary::log2(bound), 0.0, 1.0);
}

}  // namespace

Status write_residual_png(const std::string& path, const SplitResult& result, int width, int height) {
    if (width <= 0 || height <= 0 ||
        result.residual.size() != static_cast<std::size_t>(width) * static_cast<std::size_t>(height))
        return error_at({path, 0, 0}, "the result has " + std::to_string(result.residual.size()) +
                                          " pixels; expected " + std::to_string(width) + " x " +
                                          std::to_string(height));
    const double limit = residual_limit(result.bound, result.allowance);
    std::vector<unsigned char> rgb;
    rgb.reserve(result.residual.size() * 3);
    for (const float residual : result.residual) {
        const std::array<unsigned char, 3> color = !std::isfinite(residual) ? std::array<unsigned char, 3>{0, 255, 255}
                                                   : residual == 0          ? std::array<unsigned char, 3>{0, 0, 0}
                                                                   : scale_color(anchors, position_of(residual, limit));
        rgb.insert(rgb.end(), color.begin(), color.end());
    }
    return write_png(path, width, height, rgb);
}

}  // namespace raylex::display
