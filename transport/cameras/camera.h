// The interface of cameras: from raster positions to rays, and from points of the scene back to the raster.
//
// Camera space is pbrt-v4's: left-handed, x to the right of the image, y up, +z forward. Raster (0, 0) is the top left
// corner of the image, and a pixel is 1 x 1.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "display/services/registry.h"
#include "lpe/result.h"
#include "transport/geometry/ray.h"
#include "transport/math/transform.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

/// The connection of a point in front of the camera with the camera.
struct CameraConnection {
    Vec3 position;      ///< world: the pinhole, or a point of the lens
    Real x = 0, y = 0;  ///< raster position; it may lie outside the image
    /// Raster area (pixels) per area at the point that faces the camera, as a mean over the lens. Radiance from the
    /// point, times |cos| at the point, times this is the contribution per area at the point and raster area.
    Real importance = 0;
};

/// The random numbers of a camera ray.
struct CameraSample {
    Real x = 0, y = 0;  ///< raster position
    Vec2 lens;          ///< in [0, 1)^2; (0, 0) for cameras without a lens
    Real time = 0;      ///< of the ray
};

class CameraMotion;
struct CameraPlacement;
class PerspectiveCamera;
struct Placement;

/// A camera and where it stands when the shutter opens. Kinds of cameras do not implement motion; this class applies it
/// (camera_motion.h).
class Camera {
  public:
    virtual ~Camera();
    Camera(const Camera&) = delete;
    Camera& operator=(const Camera&) = delete;

    /// Writes the ray of samples[i] to rays[i], in world space with a unit direction. Its cone spreads by the angle of
    /// a pixel in the middle of the image, where that is known. Called once a batch.
    virtual void generate(std::span<const CameraSample> samples, std::span<Ray> rays) const = 0;
    /// generate() with each ray at its sample's time, from the camera's place at that time.
    void generate_in_time(std::span<const CameraSample> samples, std::span<Ray> rays) const;
    /// generate_in_time() for a camera with weighs_rays(): weights[i] multiplies the radiance along rays[i]. If no
    /// light reaches the film along the ray, the weight is 0 and t_max is 0, so that the ray hits nothing.
    void generate_weighed(std::span<const CameraSample> samples, std::span<Ray> rays, std::span<Real> weights) const;
    /// Whether rays have different weights. Light paths cannot be connected to such a camera: connect() and
    /// importance() do not read the weights, and integrators without the trait camera_weights refuse the camera.
    [[nodiscard]] virtual bool weighs_rays() const { return false; }
    /// One ray at its time. generate(), connect() and importance() are called for every vertex of a path, so the
    /// perspective camera is called without a virtual call.
    [[nodiscard]] Ray generate(const CameraSample& sample) const;
    /// Connects a point in world space with the camera through `lens` in [0, 1)^2 at `time`. Returns false if the point
    /// is not in front of the camera.
    [[nodiscard]] bool connect(const Vec3& point, const Vec2& lens, Real time, CameraConnection& connection) const;
    /// CameraConnection::importance of `point` seen from `position` on the lens, for a camera ray that began at `time`;
    /// 0 if the point is not in front of the camera.
    [[nodiscard]] Real importance(const Vec3& point, const Vec3& position, Real time) const;
    /// Whether rays through one raster position begin in different places.
    [[nodiscard]] bool has_lens() const { return has_lens_; }

    /// Width and height of a pixel on the plane at distance 1 before the camera. Wireframes scale them with depth.
    [[nodiscard]] Vec2 pixel_size() const { return pixel_size_; }
    /// World to camera space without its scale (mirroring stays). For a moving camera: at the time when the shutter
    /// opens.
    void rigid_world_to_camera(Real (&matrix)[3][4]) const;
    [[nodiscard]] const Matrix4& world_to_camera() const { return world_to_camera_; }
    /// World to [-1, 1]^2 over the image, y up, after division by w.
    [[nodiscard]] const Matrix4& world_to_screen() const { return world_to_screen_; }

  protected:
    /// `camera_to_screen` is the matrix of world_to_screen(), but from camera space.
    Camera(const Transform& camera_to_world, const Matrix4& camera_to_screen, const Vec2& pixel_size, bool has_lens);
    std::vector<Error> warnings_;  ///< about the parameters; make_camera() returns them

  private:
    friend class PerspectiveCamera;
    friend Result<std::unique_ptr<Camera>> make_camera(const SceneEntity&, const CameraPlacement&, std::vector<Error>&);
    [[nodiscard]] bool connect_at_rest(const Vec3& point, const Vec2& lens, CameraConnection& connection) const;
    [[nodiscard]] Real importance_at_rest(const Vec3& point, const Vec3& position) const;
    [[nodiscard]] Real carried_importance(const Placement& carry, const Vec3& first_point, const Vec3& first_position,
                                          Real importance) const;
    /// Moves the rays to the camera's place at their times, and sets their times.
    void carry(std::span<const CameraSample> samples, std::span<Ray> rays) const;
    /// generate_weighed() for a camera that does not move.
    virtual void weigh(std::span<const CameraSample> samples, std::span<Ray> rays, std::span<Real> weights) const;
    [[nodiscard]] virtual bool connect_to(const Vec3& point, const Vec2& lens, CameraConnection& connection) const = 0;
    [[nodiscard]] virtual Real importance_of(const Vec3& point, const Vec3& position) const = 0;

    Matrix4 world_to_camera_{}, world_to_screen_{};
    Vec2 pixel_size_;
    bool has_lens_ = false;
    const PerspectiveCamera* perspective_ = nullptr;  // this object, if it is a perspective camera
    std::shared_ptr<const CameraMotion> motion_;      // null: the camera does not move
};

/// Where a camera stands, and the size of its image.
struct CameraPlacement {
    Transform camera_to_world;  ///< invertible
    int width = 0, height = 0;  ///< of the image, pixels
    /// a pinhole uses the code of a lens with radius 0, with the same bits
    bool lens_code = false;
    std::shared_ptr<const CameraMotion> motion{};  ///< null: the camera does not move
    double film_diagonal = 35;                     ///< millimetres; for cameras whose film has a size
};

/// Builds a camera. Errors name the directive or the parameter.
using CameraFactory = std::function<Result<std::unique_ptr<Camera>>(const SceneEntity&, const CameraPlacement&)>;
/// The registered cameras: perspective, orthographic, spherical, realistic, and those of plugins.
Registry<CameraFactory>& camera_registry();

/// Makes the camera of a scene; an empty type means perspective. Errors: an unknown type, a transform without inverse,
/// a position beyond what can be traced, errors of the factory. Unused parameters are warnings.
Result<std::unique_ptr<Camera>> make_camera(const SceneEntity& entity, const CameraPlacement& placement,
                                            std::vector<Error>& warnings);

}  // namespace raylex::transport
