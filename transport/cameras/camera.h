// What a camera is: from raster positions to rays, and from points of the scene back to the raster.
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

/// How a point in front of the camera is seen: from where, and where on the raster.
struct CameraConnection {
    Vec3 position;      ///< world: the pinhole, or a point of the lens
    Real x = 0, y = 0;  ///< raster position; it may lie outside the image
    /// Raster area (pixels) for each area at the point that faces the camera: what radiance from there times |cos| at
    /// the point counts for, per area at the point and raster area. Mean over the lens.
    Real importance = 0;
};

/// What a camera ray is made of.
struct CameraSample {
    Real x = 0, y = 0;  ///< raster position
    Vec2 lens;          ///< in [0, 1)^2; (0, 0) for cameras without a lens
    Real time = 0;      ///< the ray's
};

class CameraMotion;
struct CameraPlacement;
class PerspectiveCamera;
struct Placement;

/// A camera stands where it does when the shutter opens: kinds of cameras know of no motion, which is this class's
/// business (camera_motion.h).
class Camera {
  public:
    virtual ~Camera();
    Camera(const Camera&) = delete;
    Camera& operator=(const Camera&) = delete;

    /// rays[i] is the ray of samples[i], in world space, its direction a unit vector; its cone spreads by a pixel's
    /// angle in the middle of the image where it is known. Called once a batch.
    virtual void generate(std::span<const CameraSample> samples, std::span<Ray> rays) const = 0;
    /// The same with each ray at its sample's time, from where the camera is then.
    void generate_in_time(std::span<const CameraSample> samples, std::span<Ray> rays) const;
    /// The same for a camera with weighs_rays(): weights[i] is what light along rays[i] counts for; of one that no
    /// light comes along it is 0, and the ray meets nothing (t_max is 0).
    void generate_weighed(std::span<const CameraSample> samples, std::span<Ray> rays, std::span<Real> weights) const;
    /// Whether light counts differently along its rays. Such a camera is nothing that light paths can be connected to:
    /// connect() and importance() do not ask it, and integrators without the trait camera_weights refuse it.
    [[nodiscard]] virtual bool weighs_rays() const { return false; }
    /// One ray, at its time. These three are asked for every vertex of a path: the perspective camera is called without
    /// indirection.
    [[nodiscard]] Ray generate(const CameraSample& sample) const;
    /// How the camera sees a point in world space through `lens` in [0, 1)^2 at `time`; false for what is not in front
    /// of it.
    [[nodiscard]] bool connect(const Vec3& point, const Vec2& lens, Real time, CameraConnection& connection) const;
    /// CameraConnection::importance of `point` as seen from `position`, where a camera ray began at `time`. 0 for what
    /// is not in front of the camera.
    [[nodiscard]] Real importance(const Vec3& point, const Vec3& position, Real time) const;
    /// Whether rays through one raster position begin in different places.
    [[nodiscard]] bool has_lens() const { return has_lens_; }

    /// Width and height of a pixel on the plane at distance 1 before the camera; what wireframes take them for at every
    /// depth in proportion.
    [[nodiscard]] Vec2 pixel_size() const { return pixel_size_; }
    /// World to camera space without its scale (a mirroring stays); of a moving camera, when the shutter opens.
    void rigid_world_to_camera(Real (&matrix)[3][4]) const;
    [[nodiscard]] const Matrix4& world_to_camera() const { return world_to_camera_; }
    /// World to [-1, 1]^2 over the image, y up, after division by w.
    [[nodiscard]] const Matrix4& world_to_screen() const { return world_to_screen_; }

  protected:
    /// `camera_to_screen` as world_to_screen(), from camera space.
    Camera(const Transform& camera_to_world, const Matrix4& camera_to_screen, const Vec2& pixel_size, bool has_lens);
    std::vector<Error> warnings_;  ///< of what was read; make_camera() passes them on

  private:
    friend class PerspectiveCamera;
    friend Result<std::unique_ptr<Camera>> make_camera(const SceneEntity&, const CameraPlacement&, std::vector<Error>&);
    [[nodiscard]] bool connect_at_rest(const Vec3& point, const Vec2& lens, CameraConnection& connection) const;
    [[nodiscard]] Real importance_at_rest(const Vec3& point, const Vec3& position) const;
    [[nodiscard]] Real carried_importance(const Placement& carry, const Vec3& first_point, const Vec3& first_position,
                                          Real importance) const;
    /// Where the rays are at their times, and when.
    void carry(std::span<const CameraSample> samples, std::span<Ray> rays) const;
    /// generate_weighed() for a camera that does not move.
    virtual void weigh(std::span<const CameraSample> samples, std::span<Ray> rays, std::span<Real> weights) const;
    [[nodiscard]] virtual bool connect_to(const Vec3& point, const Vec2& lens, CameraConnection& connection) const = 0;
    [[nodiscard]] virtual Real importance_of(const Vec3& point, const Vec3& position) const = 0;

    Matrix4 world_to_camera_{}, world_to_screen_{};
    Vec2 pixel_size_;
    bool has_lens_ = false;
    const PerspectiveCamera* perspective_ = nullptr;  // this object, when it is one
    std::shared_ptr<const CameraMotion> motion_;      // null: it stands still
};

/// Where a camera stands and what it fills.
struct CameraPlacement {
    Transform camera_to_world;                     ///< invertible
    int width = 0, height = 0;                     ///< of the image, pixels
    bool lens_code = false;                        ///< a pinhole goes the way of a lens of radius 0, to the same bits
    std::shared_ptr<const CameraMotion> motion{};  ///< null: it stands still
    double film_diagonal = 35;                     ///< millimetres; of cameras whose film has a size
};

/// Errors name the directive, or the parameter.
using CameraFactory = std::function<Result<std::unique_ptr<Camera>>(const SceneEntity&, const CameraPlacement&)>;
/// perspective, orthographic, spherical, realistic; plugins add theirs.
Registry<CameraFactory>& camera_registry();

/// The camera of a scene; an empty type means perspective. Errors: a type nobody knows, a transform without inverse, a
/// place beyond what can be traced, the factory's. Parameters that nobody reads are warnings.
Result<std::unique_ptr<Camera>> make_camera(const SceneEntity& entity, const CameraPlacement& placement,
                                            std::vector<Error>& warnings);

}  // namespace raylex::transport
