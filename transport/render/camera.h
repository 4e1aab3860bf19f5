// The perspective camera, by pbrt-v4's conventions: left-handed camera space, x to the right of the image, y up, +z
// forward; "fov" spans the shorter axis of the film; raster (0, 0) is the top left corner.
#pragma once

#include <optional>

#include "lpe/result.h"
#include "transport/geometry/matrix34.h"
#include "transport/geometry/ray.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

/// How a point in front of the camera is seen: from where, and where on the raster.
struct CameraConnection {
    Vec3 position;         ///< world: the pinhole, or a point of the lens
    Real x = 0, y = 0;     ///< raster position; it may lie outside the image
    /// Raster area (pixels) for each area at the point that faces the camera: what radiance from there times |cos| at the
    /// point counts for, per area at the point and raster area. Mean over the lens.
    Real importance = 0;
};

class PerspectiveCamera {
  public:
    /// An empty type means perspective. Other cameras are an Error at the directive; unknown parameters are warnings.
    static Result<PerspectiveCamera> build(const SceneEntity& entity, const Transform& camera_to_world, int width,
                                           int height, std::vector<Error>& warnings);

    /// The ray through raster position (x, y); `lens` in [0, 1)^2. Its direction is unit, in world space; its cone
    /// spreads by a pixel's angle in the middle of the image, and it flies at the time 0.
    [[nodiscard]] Ray generate(Real x, Real y, const Vec2& lens) const;
    /// How the camera sees a point in world space through `lens` in [0, 1)^2; false for what is not in front of it.
    [[nodiscard]] bool connect(const Vec3& point, const Vec2& lens, CameraConnection& connection) const;
    /// CameraConnection::importance of `point` as seen from `position`, the pinhole or a point of the lens. 0 for what is not
    /// in front of it.
    [[nodiscard]] Real importance(const Vec3& point, const Vec3& position) const;
    [[nodiscard]] bool has_lens() const { return lens_radius_ > 0; }

    /// Width and height of a pixel on the plane at distance 1 before the camera.
    [[nodiscard]] Vec2 pixel_size() const { return {std::abs(step_x_.x), std::abs(step_y_.y)}; }
    /// World to camera space without its scale (a mirroring stays).
    void rigid_world_to_camera(Real (&matrix)[3][4]) const;
    [[nodiscard]] const Matrix4& world_to_camera() const { return world_to_camera_; }
    /// World to [-1, 1]^2 over the image, y up, after division by w.
    [[nodiscard]] const Matrix4& world_to_screen() const { return world_to_screen_; }

  private:
    [[nodiscard]] Real importance_at(double depth, const Vec3& point, const Vec3& position) const;
    Transform camera_to_world_;
    Vec3 corner_, step_x_, step_y_;  // camera space, at z = 1: raster (0, 0) and one pixel right and down
    Vec3 origin_;                    // world
    Real lens_radius_ = 0, focal_distance_ = 1e6f, pixel_angle_ = 0;
    Matrix34 to_camera_;
    double raster_density_ = 0;      // pixels for each area on the plane at distance 1, in volume units of the world
    Matrix4 world_to_camera_{}, world_to_screen_{};
};

/// Width, height and what of a Film directive cannot be honoured.
struct FilmSettings {
    int width = 1280, height = 720;
};
Result<FilmSettings> read_film(const SceneEntity& film, const std::optional<std::array<int, 2>>& resolution,
                               std::vector<Error>& warnings);

}  // namespace raylex::transport
