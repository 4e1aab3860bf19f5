// The orthographic camera: parallel rays along +z, from the plane z = 0 of camera space.
//
// With a lens, every point of the film has a lens of its own around it, and all of them focus on the plane at
// "focaldistance": a telecentric lens, which images that plane as the pinhole does. (pbrt-v4 moves all rays to the one
// lens around the origin, which makes the image perspective.)
#pragma once

#include "transport/cameras/camera.h"
#include "transport/math/matrix34.h"

namespace raylex::transport {

class OrthographicCamera final : public Camera {
  public:
    /// Builds the camera for the registry.
    static Result<std::unique_ptr<Camera>> build(const SceneEntity& entity, const CameraPlacement& placement);

    using Camera::generate;
    void generate(std::span<const CameraSample> samples, std::span<Ray> rays) const override;

  private:
    OrthographicCamera(const Transform& camera_to_world, const Matrix4& projection, const Vec2& pixel_size,
                       bool has_lens);
    [[nodiscard]] bool connect_to(const Vec3& point, const Vec2& lens, CameraConnection& connection) const override;
    [[nodiscard]] Real importance_of(const Vec3& point, const Vec3& position) const override;
    Placement placement_;
    double corner_x_ = 0, corner_y_ = 0, step_x_ = 0, step_y_ = 0;  // camera space: raster (0, 0), and a pixel's step
    double lens_radius_ = 0, focal_distance_ = 1e6;
    Real pixel_width_ = 0;  // in the world
    double density_ = 0;    // pixels per volume of the world that a step of 1 in z sweeps
};

}  // namespace raylex::transport
