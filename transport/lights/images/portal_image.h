// Image environments that are seen through a portal alone: B. Bitterli, J. Novak and W. Jarosz 2015, "Portal-Masked
// Environment Map Sampling", Computer Graphics Forum 34(4), as pbrt-v4's infinite lights with "portal".
//
// The image is turned into the angles (atan(x / z), atan(y / z)) of the portal's frame, z pointing out through it. In
// those a rectangular portal is a rectangle from wherever it is seen, and a table of sums gives the integral over any
// rectangle, so that directions are drawn from the image behind the portal and nowhere else. As in pbrt-v4 the turned
// image (of the image's own resolution, interpolated at the centres of its pixels) is what the light shows.
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
    /// Corners of a rectangle, one after the other around it.
    using Corners = std::array<DVec3, 4>;
    /// What is wrong with it; nothing where its sides are within 1 % of a rectangle's.
    static std::optional<std::string> problem_of(const Corners& corners);

    /// `image` is square, equal-area octahedral in the space that `placement` places; the corners stand in the world.
    PortalImage(const RgbImage& image, const Placement& placement, const Corners& corners);

    /// What arrives at `from` out of a unit direction: black where that does not pass the portal.
    [[nodiscard]] Rgb radiance(const Vec3& from, const Vec3& direction) const;
    /// With which sample() draws the direction, per steradian.
    [[nodiscard]] Real pdf(const Vec3& from, const Vec3& direction) const;
    /// False where nothing arrives.
    [[nodiscard]] bool sample(const Vec3& from, const Vec2& u, Vec3& direction, Rgb& radiance, Real& pdf) const;

    // Of light that comes in through the portal anywhere.

    /// As pdf(), from the whole image.
    [[nodiscard]] Real emission_pdf(const Vec3& direction) const;
    [[nodiscard]] bool sample_emission(const Vec2& u, Vec3& direction, Rgb& radiance, Real& pdf) const;
    /// A point of the portal, uniform; u in [0, 1)^2.
    [[nodiscard]] Vec3 point(const Vec2& u) const;
    /// Per area across a beam that comes from `direction`.
    [[nodiscard]] Real density_across(const Vec3& direction) const;
    /// The luminance that passes it, over all directions: watts-like.
    [[nodiscard]] double flux() const { return flux_; }

  private:
    struct Window {
        double x0 = 0, y0 = 0, x1 = 1, y1 = 1;  // in [0, 1]^2 of the turned image
    };
    [[nodiscard]] bool window_from(const Vec3& from, Window& window) const;
    [[nodiscard]] DVec3 to_frame(const DVec3& v) const { return {dot(v, s_), dot(v, t_), dot(v, n_)}; }
    /// Of a direction in the portal's frame, z > 0.
    [[nodiscard]] static Vec2 image_point(const DVec3& local);
    [[nodiscard]] std::size_t pixel_of(const Vec2& at) const;
    /// Of the weights, over [0, x] x [0, y].
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
