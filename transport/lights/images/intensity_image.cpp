#include "transport/lights/images/intensity_image.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "display/services/elementary.h"
#include "transport/lights/images/environment.h"
#include "transport/math/sampling.h"

namespace raylex::transport {

IntensityImage::IntensityImage(RgbImage image, const Placement& placement)
    : image_(std::move(image)), placement_(placement) {}

IntensityImage IntensityImage::goniometric(RgbImage image, const Placement& placement) {
    IntensityImage light(std::move(image), placement);
    std::vector<double> weights;
    for (const Rgb& pixel : light.image_.pixels) weights.push_back(sampling_weight(pixel));
    light.distribution_ = PixelDistribution(light.image_.width, light.image_.height, weights);
    light.flux_ = 4 * std::numbers::pi * light.image_.mean_luminance();
    return light;
}

IntensityImage IntensityImage::projection(RgbImage image, double fov, const Placement& placement) {
    IntensityImage light(std::move(image), placement);
    const int width = light.image_.width, height = light.image_.height;
    const double tangent = elementary::tan(fov * std::numbers::pi / 360),
                 aspect = static_cast<double>(width) / static_cast<double>(height);
    light.projects_ = true;
    light.half_width_ = tangent * std::max(aspect, 1.0);
    light.half_height_ = tangent * std::max(1 / aspect, 1.0);
    std::vector<double> weights;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const DVec3 w = light.direction_of({(static_cast<Real>(x) + Real(0.5)) / static_cast<Real>(width),
                                                (static_cast<Real>(y) + Real(0.5)) / static_cast<Real>(height)});
            const double cubed = w.z * w.z * w.z;  // of area facing the light at distance 1 to solid angle
            weights.push_back(sampling_weight(light.image_.at(x, y)) * cubed);
            light.flux_ += luminance(light.image_.at(x, y)) * cubed;
        }
    light.flux_ *= 4 * light.half_width_ * light.half_height_ / static_cast<double>(weights.size());
    light.distribution_ = PixelDistribution(width, height, weights);
    return light;
}

bool IntensityImage::image_point(const DVec3& d, Vec2& at) const {
    if (!projects_) {
        at = octahedral_from_direction({static_cast<Real>(d.x), static_cast<Real>(d.z), static_cast<Real>(d.y)});
        return true;
    }
    if (!(d.z > 0)) return false;
    const double x = d.x / (d.z * half_width_), y = d.y / (d.z * half_height_);
    if (!(std::abs(x) <= 1 && std::abs(y) <= 1)) return false;
    at = {static_cast<Real>(0.5 + 0.5 * x), static_cast<Real>(0.5 - 0.5 * y)};
    return true;
}

DVec3 IntensityImage::direction_of(const Vec2& at) const {
    if (!projects_) {
        const Vec3 d = direction_from_octahedral(at);
        return DVec3(Vec3{d.x, d.z, d.y});
    }
    return normalize(DVec3{(2 * static_cast<double>(at.x) - 1) * half_width_,
                           (1 - 2 * static_cast<double>(at.y)) * half_height_, 1});
}

DVec3 IntensityImage::to_light(const Vec3& world_direction) const {
    return normalize(placement_.to_object.vector(DVec3(world_direction)));
}

Real IntensityImage::per_steradian(Real density, const DVec3& d) const {
    const double mapped = solid_angle_ratio(placement_.to_world, d);
    const double of_image = projects_ ? 1 / (4 * half_width_ * half_height_ * d.z * d.z * d.z) : uniform_sphere_pdf();
    return static_cast<Real>(static_cast<double>(density) * of_image * mapped);
}

Rgb IntensityImage::intensity(const Vec3& world_direction) const {
    Vec2 at;
    return image_point(to_light(world_direction), at) ? image_.pixels[distribution_.pixel_of(at)] : Rgb();
}

Real IntensityImage::pdf(const Vec3& world_direction) const {
    const DVec3 direction = to_light(world_direction);
    Vec2 at;
    return image_point(direction, at) ? per_steradian(distribution_.density_at(at), direction) : Real(0);
}

bool IntensityImage::sample(const Vec2& u, Vec3& world_direction, Rgb& intensity, Real& pdf) const {
    const PixelDistribution::Drawn drawn = distribution_.sample(u);
    if (!(drawn.density > 0)) return false;
    const DVec3 direction = direction_of(drawn.at);
    world_direction = normalize(placement_.to_world.vector(direction)).to_real();
    intensity = image_.pixels[drawn.pixel];
    pdf = per_steradian(drawn.density, direction);
    return pdf > 0;
}

Real IntensityImage::versine(const Vec3& axis) const {
    if (!projects_) return 2;
    double widest = 0;
    for (const double x : {-half_width_, half_width_})
        for (const double y : {-half_height_, half_height_}) {
            const DVec3 corner = normalize(placement_.to_world.vector({x, y, 1}));
            widest = std::max(widest, 1 - dot(corner, DVec3(axis)));
        }
    return static_cast<Real>(widest);
}

}  // namespace raylex::transport
