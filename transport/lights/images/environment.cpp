#include "transport/lights/images/environment.h"

#include <cmath>

#include "transport/math/sampling.h"

namespace raylex::transport {

namespace {

/// The share of a pixel's own radiance in the weights of By::excess.
constexpr Real share_of_all = Real(0.1);

}  // namespace

EnvironmentImage::EnvironmentImage(int resolution, std::vector<Rgb> pixels, const Placement& placement)
    : pixels_(std::move(pixels)), placement_(placement) {
    std::vector<double> weights(pixels_.size());
    double sum = 0, luminances = 0;
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
        weights[i] = double{sampling_weight(pixels_[i])};
        sum += weights[i];
        luminances += luminance(pixels_[i]);
    }
    const auto count = static_cast<double>(pixels_.size());
    mean_ = luminances / count;
    by_radiance_ = PixelDistribution(resolution, resolution, weights);
    const Real mean = static_cast<Real>(sum / count);
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
        const Real weight = sampling_weight(pixels_[i]);
        weights[i] = double{std::max(weight - mean, Real(0))} + double{share_of_all} * double{weight};
    }
    by_excess_ = PixelDistribution(resolution, resolution, weights);
}

std::size_t EnvironmentImage::pixel_of(const Vec3& world_direction) const {
    const DVec3 local = normalize(placement_.to_object.vector(DVec3(world_direction)));
    return by_radiance_.pixel_of(octahedral_from_direction(local.to_real()));
}

Rgb EnvironmentImage::radiance(const Vec3& world_direction) const {
    return pixels_[pixel_of(world_direction)];
}
Real EnvironmentImage::pdf(const Vec3& world_direction, By by) const {
    return drawn(by).density(pixel_of(world_direction)) * uniform_sphere_pdf();
}

bool EnvironmentImage::sample(const Vec2& u, Vec3& world_direction, Rgb& radiance, Real& pdf, By by) const {
    const PixelDistribution::Drawn at = drawn(by).sample(u);
    pdf = at.density * uniform_sphere_pdf();
    if (!(pdf > 0)) return false;
    world_direction = normalize(placement_.to_world.vector(DVec3(direction_from_octahedral(at.at)))).to_real();
    radiance = pixels_[at.pixel];
    return true;
}

}  // namespace raylex::transport
