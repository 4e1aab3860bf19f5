// Image environments: radiance from every direction, in pbrt-v4's equal-area octahedral layout (math/octahedral.h),
// importance-sampled.
//
// Look-ups take the nearest pixel, as pbrt-v4's image light does, so a piecewise-constant density over the pixels is
// exactly proportional to the luminance, and every pixel covers the same solid angle.
#pragma once

#include <algorithm>
#include <vector>

#include "transport/geometry/matrix34.h"
#include "transport/lights/images/pixel_distribution.h"
#include "transport/math/octahedral.h"
#include "transport/math/real.h"

namespace raylex::transport {

/// What a pixel is sampled by: the mean of its channels serves every primary alike.
inline Real sampling_weight(const Rgb& c) {
    return std::max(c.average(), Real(0));
}

class EnvironmentImage {
  public:
    /// `pixels` row-major from the top, resolution^2 of them.
    EnvironmentImage(int resolution, std::vector<Rgb> pixels, const Placement& placement);

    [[nodiscard]] Rgb radiance(const Vec3& world_direction) const;
    /// Per steradian; 0 where the image is black.
    [[nodiscard]] Real pdf(const Vec3& world_direction) const;
    /// A world direction, or false when the image is black everywhere.
    bool sample(const Vec2& u, Vec3& world_direction, Rgb& radiance, Real& pdf) const;
    [[nodiscard]] double mean_luminance() const { return mean_; }

  private:
    [[nodiscard]] std::size_t pixel_of(const Vec3& world_direction) const;
    std::vector<Rgb> pixels_;
    PixelDistribution distribution_;
    Placement placement_;
    double mean_ = 0;
};

}  // namespace raylex::transport
