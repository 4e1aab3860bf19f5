// Lights at a point that send an image into the directions around them: goniometric diagrams in the equal-area
// octahedral layout, and projections through a pinhole, by pbrt-v4's conventions. Look-ups take the nearest pixel, so
// what is drawn by pixel is drawn in proportion to the intensity (a projection's within the solid angle of one pixel).
#pragma once

#include "transport/lights/images/pixel_distribution.h"
#include "transport/lights/images/rgb_image.h"
#include "transport/math/matrix34.h"

namespace raylex::transport {

class IntensityImage {
  public:
    /// Over all directions; `image` is square. The image's axis is y of `placement`, z and y exchanged as in pbrt-v4.
    static IntensityImage goniometric(RgbImage image, const Placement& placement);
    /// Along +z, y up, the shorter side of the image spanning `fov` degrees, 0 < fov < 180.
    static IntensityImage projection(RgbImage image, double fov, const Placement& placement);

    /// What the image holds in a unit direction away from the light, in the world; black outside of a projection.
    [[nodiscard]] Rgb intensity(const Vec3& world_direction) const;
    /// With which sample() draws it, per steradian.
    [[nodiscard]] Real pdf(const Vec3& world_direction) const;
    /// False where the image is black.
    [[nodiscard]] bool sample(const Vec2& u, Vec3& world_direction, Rgb& intensity, Real& pdf) const;
    /// The integral of the luminance over the directions.
    [[nodiscard]] double flux() const { return flux_; }
    /// 1 - cos of the angle from the world's `axis` within which all light goes: 2 for a goniometric one.
    [[nodiscard]] Real versine(const Vec3& axis) const;

  private:
    IntensityImage(RgbImage image, const Placement& placement);
    /// In the light's own space; false outside of the image.
    [[nodiscard]] bool image_point(const DVec3& direction, Vec2& at) const;
    [[nodiscard]] DVec3 direction_of(const Vec2& at) const;
    [[nodiscard]] DVec3 to_light(const Vec3& world_direction) const;
    /// Of the image's density: from the unit square to directions of the world.
    [[nodiscard]] Real per_steradian(Real density, const DVec3& direction) const;

    RgbImage image_;
    PixelDistribution distribution_;
    Placement placement_;
    bool projects_ = false;
    double half_width_ = 0, half_height_ = 0;  // of a projection, at distance 1
    double flux_ = 0;
};

}  // namespace raylex::transport
