// The perspective camera, a pinhole or a thin lens, by pbrt-v4's conventions: "fov" spans the shorter axis of the film.
#pragma once

#include "transport/cameras/camera.h"
#include "transport/math/matrix34.h"

namespace raylex::transport {

class PerspectiveCamera final : public Camera {
  public:
    /// Builds the camera for the registry.
    static Result<std::unique_ptr<Camera>> build(const SceneEntity& entity, const CameraPlacement& placement);

    using Camera::generate;
    void generate(std::span<const CameraSample> samples, std::span<Ray> rays) const override;
    [[nodiscard]] Ray ray(Real x, Real y, const Vec2& lens) const;
    [[nodiscard]] bool connect_to(const Vec3& point, const Vec2& lens, CameraConnection& connection) const override;
    [[nodiscard]] Real importance_of(const Vec3& point, const Vec3& position) const override;

  private:
    PerspectiveCamera(const Transform& camera_to_world, const Matrix4& projection, const Vec2& pixel_size,
                      bool has_lens);
    [[nodiscard]] Real importance_at(double depth, const Vec3& point, const Vec3& position) const;
    Transform camera_to_world_, for_directions_;
    Vec3 corner_, step_x_, step_y_;  // camera space, at z = 1: raster (0, 0) and one pixel right and down
    Vec3 origin_;                    // world
    Real lens_radius_ = 0, focal_distance_ = 1e6f, pixel_angle_ = 0;
    Matrix34 to_camera_;
    Real focal_in_unit_ = 1, lens_in_unit_ = 0;  // in units of a power of two near the focal distance
    double raster_density_ = 0;  // pixels per area on the plane at distance 1, in volume units of the world
};

}  // namespace raylex::transport
