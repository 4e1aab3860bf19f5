#include "transport/lights/area_images.h"

#include <algorithm>
#include <cmath>

#include "transport/lights/area_points.h"

namespace raylex::transport {
namespace {

/// A point of the primitive (u and v of a Hit), and the world area per area of the unit square.
struct Place {
    Vec2 at;
    double area = 0;
};

Place place_of(const Light& light, const ShapeGeometry& shape, const Vec2& numbers) {
    LightSample s;
    Real density = 0;
    if (light.kind == LightKind::triangle) density = sample_triangle_point(light, numbers, s);
    else if (light.kind == LightKind::patch) density = sample_patch_point(light, shape, numbers, s);
    else density = sample_quadric_point(shape.quadric, numbers, s);
    return {s.uv, density > 0 ? 1 / static_cast<double>(density) : 0};
}

/// The number of image pixels along the primitive's edges, for the longer side.
double pixels_along(const Light& light, const ShapeGeometry& shape, const RgbImage& image) {
    Vec2 lower{infinity, infinity}, upper{-infinity, -infinity};
    constexpr int steps = 4;
    for (int y = 0; y <= steps; ++y)
        for (int x = 0; x <= steps; ++x) {
            const Vec2 numbers{static_cast<Real>(x) / steps, static_cast<Real>(y) / steps};
            const Vec2 at = texture_coordinates(shape, light.primitive, place_of(light, shape, numbers).at);
            lower = {std::min(lower.x, at.x), std::min(lower.y, at.y)};
            upper = {std::max(upper.x, at.x), std::max(upper.y, at.y)};
        }
    return std::max(static_cast<double>(upper.x - lower.x) * image.width,
                    static_cast<double>(upper.y - lower.y) * image.height);
}

}  // namespace

PrimitiveImage image_on_primitive(const Light& light, const ShapeGeometry& shape, const EmissionImage& shown) {
    const double most = std::sqrt(0x1p20 / std::max(1.0, static_cast<double>(shape.primitive_count)));
    const double wanted = pixels_along(light, shape, shown.image);
    const int cells = static_cast<int>(std::clamp(std::ceil(wanted), 1.0, std::clamp(std::floor(most), 1.0, 256.0)));
    // Each pixel that a cell covers is read about once.
    const int looks = static_cast<int>(std::clamp(std::ceil(wanted / cells), 2.0, 16.0));
    std::vector<double> weights(static_cast<std::size_t>(cells) * static_cast<std::size_t>(cells));
    double total = 0, area = 0, luminance_sum = 0;
    const Real step = 1 / static_cast<Real>(cells * looks);
    for (int y = 0; y < cells * looks; ++y)
        for (int x = 0; x < cells * looks; ++x) {
            const Place place = place_of(
                light, shape, {(static_cast<Real>(x) + Real(0.5)) * step, (static_cast<Real>(y) + Real(0.5)) * step});
            const Vec2 at = texture_coordinates(shape, light.primitive, place.at);
            const Rgb radiance = shown.radiance(at.x, at.y);
            const double weight = std::max(radiance.average(), Real(0)) * place.area;
            weights[static_cast<std::size_t>(y / looks) * static_cast<std::size_t>(cells) +
                    static_cast<std::size_t>(x / looks)] += weight;
            total += weight;
            area += place.area;
            luminance_sum += luminance(radiance) * place.area;
        }
    if (total > 0)
        for (double& weight : weights) weight = 0.9 * weight + 0.1 * total / static_cast<double>(weights.size());
    return {PixelDistribution(cells, cells, weights), area > 0 ? luminance_sum / area : 0};
}

}  // namespace raylex::transport
