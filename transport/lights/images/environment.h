// Image environments: radiance from every direction, in pbrt-v4's equal-area octahedral layout (math/octahedral.h),
// importance-sampled.
//
// Where scattering finds the sky too, light samples are drawn by the excess over the mean (MIS compensation: O. Karlik
// et al. 2019, "MIS Compensation: Optimizing Sampling Techniques in Multiple Importance Sampling", ACM TOG 38(6)). The
// weight is max(L - mean, 0) plus a share of L itself. So the density is positive wherever there is light, and light
// that scattering misses is found.
//
// Look-ups take the nearest pixel, as pbrt-v4's image light does. So a piecewise-constant density over the pixels is
// exactly proportional to the luminance, and every pixel covers the same solid angle.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "transport/lights/images/pixel_distribution.h"
#include "transport/math/matrix34.h"
#include "transport/math/octahedral.h"
#include "transport/math/real.h"

namespace raylex::transport {

/// The sampling weight of a pixel: the mean of its channels, since all primaries matter equally.
inline Real sampling_weight(const Rgb& c) {
    return std::max(c.average(), Real(0));
}

class EnvironmentImage {
  public:
    /// `pixels` is row-major from the top, with resolution^2 elements.
    EnvironmentImage(int resolution, std::vector<Rgb> pixels, const Placement& placement);

    [[nodiscard]] Rgb radiance(const Vec3& world_direction) const;
    /// The weight by which directions are drawn: radiance, or its excess over the mean.
    enum class By : std::uint8_t { radiance, excess };
    /// The density of sample() per steradian; 0 if the image is black.
    [[nodiscard]] Real pdf(const Vec3& world_direction, By by = By::radiance) const;
    /// Draws a world direction; returns false if the image is black everywhere.
    bool sample(const Vec2& u, Vec3& world_direction, Rgb& radiance, Real& pdf, By by = By::radiance) const;
    [[nodiscard]] double mean_luminance() const { return mean_; }

  private:
    [[nodiscard]] std::size_t pixel_of(const Vec3& world_direction) const;
    [[nodiscard]] const PixelDistribution& drawn(By by) const { return by == By::radiance ? by_radiance_ : by_excess_; }
    std::vector<Rgb> pixels_;
    PixelDistribution by_radiance_, by_excess_;
    Placement placement_;
    double mean_ = 0;
};

}  // namespace raylex::transport
