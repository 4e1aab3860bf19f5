// Image environments that are visible only through a portal: B. Bitterli, J. Novak and W. Jarosz 2015, "Portal-Masked
// Environment Map Sampling", Computer Graphics Forum 34(4), as pbrt-v4's infinite lights with "portal".
//
// The image is rectified to the angles (atan(x / z), atan(y / z)) of the portal's frame, with z pointing out through
// it. There a rectangular portal is a rectangle from every viewpoint, and a summed-area table gives the integral over
// any rectangle, so that directions are drawn only from the part of the image behind the portal. As in pbrt-v4 the
// light emits the rectified image (of the image's own resolution, interpolated at the centres of its pixels).
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "transport/lights/images/rgb_image.h"
#include "transport/math/matrix34.h"

namespace raylex::transport {

class PortalImage {
  public:
    /// The corners of a rectangle in order around it.
    using Corners = std::array<DVec3, 4>;
    /// Describes why the corners are not a rectangle; nothing if its sides are within 1 % of one.
    static std::optional<std::string> problem_of(const Corners& corners);

    /// `image` is square and equal-area octahedral in the space of `placement`; the corners are in the world.
    PortalImage(const RgbImage& image, const Placement& placement, const Corners& corners);

    /// The radiance that arrives at `from` from a unit direction; black if the direction misses the portal.
    [[nodiscard]] Rgb radiance(const Vec3& from, const Vec3& direction) const;
    /// The density of sample(), per steradian.
    [[nodiscard]] Real pdf(const Vec3& from, const Vec3& direction) const;
    /// Draws a direction; returns false if no light arrives.
    [[nodiscard]] bool sample(const Vec3& from, const Vec2& u, Vec3& direction, Rgb& radiance, Real& pdf) const;

    // The functions below are for light that comes in anywhere through the portal.

    /// The density of directions drawn from the whole image, per steradian.
    [[nodiscard]] Real emission_pdf(const Vec3& direction) const;
    [[nodiscard]] bool sample_emission(const Vec2& u, Vec3& direction, Rgb& radiance, Real& pdf) const;
    /// A uniform point of the portal; u in [0, 1)^2.
    [[nodiscard]] Vec3 point(const Vec2& u) const;
    /// The density of point() per area across a beam from `direction`.
    [[nodiscard]] Real density_across(const Vec3& direction) const;
    /// The luminance that passes the portal, over all directions, in relative units of power.
    [[nodiscard]] double flux() const { return flux_; }

  private:
    struct Window {
        double x0 = 0, y0 = 0, x1 = 1, y1 = 1;  // in [0, 1]^2 of the rectified image
    };
    [[nodiscard]] bool window_from(const Vec3& from, Window& window) const;
    [[nodiscard]] DVec3 to_frame(const DVec3& v) const { return {dot(v, s_), dot(v, t_), dot(v, n_)}; }
    /// The image point of a direction in the portal's frame, z > 0.
    [[nodiscard]] static Vec2 image_point(const DVec3& local);
    [[nodiscard]] std::size_t pixel_of(const Vec2& at) const;
    /// The sum of the weights over [0, x] x [0, y].
    [[nodiscard]] double sum(double x, double y) const;
    [[nodiscard]] double sum(const Window& w) const {
        return sum(w.x1, w.y1) - sum(w.x0, w.y1) - sum(w.x1, w.y0) + sum(w.x0, w.y0);
    }
    [[nodiscard]] Real density(const Window& window, const Vec2& at, const DVec3& local) const;
    [[nodiscard]] bool sample(const Window& window, const Vec2& u, Vec3& direction, Rgb& radiance, Real& pdf) const;

    int resolution_ = 0;
    std::vector<Rgb> pixels_;
    std::vector<double> weights_, sums_;  // [resolution^2], [(resolution + 1)^2]
    DVec3 corner_, opposite_, side_x_, side_y_;
    DVec3 s_, t_, n_;
    double area_ = 0, flux_ = 0;
};

}  // namespace raylex::transport
