#include "transport/lights/images/environment.h"

#include <cmath>

#include "display/services/elementary.h"
#include "transport/math/sampling.h"

namespace raylex::transport {

Vec2 octahedral_from_direction(const Vec3& d) {
    const Real x = std::abs(d.x), y = std::abs(d.y), z = std::abs(d.z);
    const Real r = safe_sqrt(1 - z);
    const Real a = std::max(x, y), b = std::min(x, y);
    Real phi = elementary::atan(a == 0 ? 0 : b / a) * (2 * inv_pi);
    if (x < y) phi = 1 - phi;
    Real v = phi * r, u = r - v;
    if (d.z < 0) {
        std::swap(u, v);
        u = 1 - u;
        v = 1 - v;
    }
    return {(std::copysign(u, d.x) + 1) * 0.5f, (std::copysign(v, d.y) + 1) * 0.5f};
}

Vec3 direction_from_octahedral(const Vec2& uv) {
    const Real u = 2 * uv.x - 1, v = 2 * uv.y - 1;
    const Real up = std::abs(u), vp = std::abs(v);
    const Real signed_distance = 1 - (up + vp);
    const Real r = 1 - std::abs(signed_distance);
    const Real phi = (r == 0 ? 1 : (vp - up) / r + 1) * (pi / 4);
    const Real z = std::copysign(1 - r * r, signed_distance);
    const Real s = r * safe_sqrt(2 - r * r);
    const auto [sine, cosine] = elementary::sin_cos(phi);
    return {std::copysign(cosine, u) * s, std::copysign(sine, v) * s, z};
}

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
