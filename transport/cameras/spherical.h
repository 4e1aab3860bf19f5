// The spherical camera: all directions around a point, y up, by pbrt-v4's mappings: "equalarea" (octahedral, every
// pixel the same solid angle; Clarberg 2008) or "equirectangular".
//
// Pixel filters of camera samples reach across the image's borders to the neighbours on the sphere. Light paths splat
// at one place, so with filters wider than a pixel they lack the part that reaches across.
#pragma once

#include "transport/cameras/camera.h"
#include "transport/math/matrix34.h"

namespace raylex::transport {

class SphericalCamera final : public Camera {
  public:
    /// Builds the camera for the registry.
    static Result<std::unique_ptr<Camera>> build(const SceneEntity& entity, const CameraPlacement& placement);

    using Camera::generate;
    void generate(std::span<const CameraSample> samples, std::span<Ray> rays) const override;

  private:
    SphericalCamera(const CameraPlacement& placement, bool equal_area);
    [[nodiscard]] bool connect_to(const Vec3& point, const Vec2& lens, CameraConnection& connection) const override;
    [[nodiscard]] Real importance_of(const Vec3& point, const Vec3& position) const override;
    Placement placement_;
    DVec3 origin_;
    double width_ = 0, height_ = 0;
    bool equal_area_ = true;
};

}  // namespace raylex::transport
