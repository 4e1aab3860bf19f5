// Lights at a point that emit an image into the directions around them: goniometric diagrams in the equal-area
// octahedral layout, and projections through a pinhole, by pbrt-v4's conventions. Look-ups take the nearest pixel, so
// sampling by pixel is proportional to the intensity (for a projection: except within the solid angle of one pixel).
#pragma once

#include "transport/lights/images/pixel_distribution.h"
#include "transport/lights/images/rgb_image.h"
#include "transport/math/matrix34.h"

namespace raylex::transport {

class IntensityImage {
  public:
    /// Makes a light over all directions; `image` is square. The image's axis is y of `placement`; z and y are swapped
    /// as in pbrt-v4.
    static IntensityImage goniometric(RgbImage image, const Placement& placement);
    /// Makes a projection along +z, y up; the shorter side of the image spans `fov` degrees, 0 < fov < 180.
    static IntensityImage projection(RgbImage image, double fov, const Placement& placement);

    /// The image value in a unit direction away from the light, in the world; black outside of a projection.
    [[nodiscard]] Rgb intensity(const Vec3& world_direction) const;
    /// The density of sample(), per steradian.
    [[nodiscard]] Real pdf(const Vec3& world_direction) const;
    /// Draws a direction; returns false if the image is black.
    [[nodiscard]] bool sample(const Vec2& u, Vec3& world_direction, Rgb& intensity, Real& pdf) const;
    /// The integral of the luminance over the directions.
    [[nodiscard]] double flux() const { return flux_; }
    /// 1 - cos of the angle from the world's `axis` that contains all light: 2 for a goniometric light.
    [[nodiscard]] Real versine(const Vec3& axis) const;

  private:
    IntensityImage(RgbImage image, const Placement& placement);
    /// The image point of a direction in the light's own space; false outside of the image.
    [[nodiscard]] bool image_point(const DVec3& direction, Vec2& at) const;
    [[nodiscard]] DVec3 direction_of(const Vec2& at) const;
    [[nodiscard]] DVec3 to_light(const Vec3& world_direction) const;
    /// Converts the image's density on the unit square to a density per steradian in the world.
    [[nodiscard]] Real per_steradian(Real density, const DVec3& direction) const;

    RgbImage image_;
    PixelDistribution distribution_;
    Placement placement_;
    bool projects_ = false;
    double half_width_ = 0, half_height_ = 0;  // of a projection, at distance 1
    double flux_ = 0;
};

}  // namespace raylex::transport
