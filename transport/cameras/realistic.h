// The realistic camera: rays from a film through the elements of a lens, by pbrt-v4's conventions. Camera space is in
// metres. The weight of a ray is cos^4 times the area from which its pupil point was drawn, over the squared distance
// of the last element. It converts the radiance that a camera without a lens measures to irradiance on the film.
#pragma once

#include <array>

#include "transport/cameras/camera.h"
#include "transport/cameras/lens_system.h"

namespace raylex::transport {

class RealisticCamera final : public Camera {
  public:
    /// Builds the camera for the registry.
    static Result<std::unique_ptr<Camera>> build(const SceneEntity& entity, const CameraPlacement& placement);

    using Camera::generate;
    void generate(std::span<const CameraSample> samples, std::span<Ray> rays) const override;
    [[nodiscard]] bool weighs_rays() const override { return true; }

  private:
    RealisticCamera(const CameraPlacement& placement, const Vec2& pixel_size, LensSystem lens);
    void weigh(std::span<const CameraSample> samples, std::span<Ray> rays, std::span<Real> weights) const override;
    [[nodiscard]] bool connect_to(const Vec3& point, const Vec2& lens, CameraConnection& connection) const override;
    [[nodiscard]] Real importance_of(const Vec3& point, const Vec3& position) const override;
    Ray ray(const CameraSample& sample, Real& weight) const;
    void find_pupils();

    /// A box on the last element's plane, for film points at (r, 0).
    struct Pupil {
        double x0 = 0, x1 = 0, y0 = 0, y1 = 0;
        [[nodiscard]] double area() const { return (x1 - x0) * (y1 - y0); }
    };
    static constexpr int pupil_count = 64;

    Placement placement_;
    LensSystem lens_;
    double film_x_ = 0, film_y_ = 0, half_diagonal_ = 0;  // metres
    double width_ = 0, height_ = 0;
    Real spread_ = 0;
    std::array<Pupil, pupil_count> pupils_{};  // by distance from the middle of the film
};

}  // namespace raylex::transport
