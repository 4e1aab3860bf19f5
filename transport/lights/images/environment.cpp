#include "transport/lights/images/environment.h"

#include <cmath>

#include "transport/math/sampling.h"

namespace raylex::transport {

EnvironmentImage::EnvironmentImage(int resolution, std::vector<Rgb> pixels, const Placement& placement)
    : pixels_(std::move(pixels)), placement_(placement) {
    std::vector<double> weights(pixels_.size());
    double luminance_sum = 0;
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
        weights[i] = sampling_weight(pixels_[i]);
        luminance_sum += luminance(pixels_[i]);
    }
    distribution_ = PixelDistribution(resolution, resolution, weights);
    mean_ = luminance_sum / (static_cast<double>(resolution) * static_cast<double>(resolution));
}

std::size_t EnvironmentImage::pixel_of(const Vec3& world_direction) const {
    const DVec3 local = normalize(placement_.to_object.vector(DVec3(world_direction)));
    return distribution_.pixel_of(octahedral_from_direction(local.to_real()));
}

Rgb EnvironmentImage::radiance(const Vec3& world_direction) const {
    return pixels_[pixel_of(world_direction)];
}
Real EnvironmentImage::pdf(const Vec3& world_direction) const {
    return distribution_.density(pixel_of(world_direction)) * uniform_sphere_pdf();
}

bool EnvironmentImage::sample(const Vec2& u, Vec3& world_direction, Rgb& radiance, Real& pdf) const {
    const PixelDistribution::Drawn drawn = distribution_.sample(u);
    pdf = drawn.density * uniform_sphere_pdf();
    if (!(pdf > 0)) return false;
    world_direction = normalize(placement_.to_world.vector(DVec3(direction_from_octahedral(drawn.at)))).to_real();
    radiance = pixels_[drawn.pixel];
    return true;
}

}  // namespace raylex::transport
