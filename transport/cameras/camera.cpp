#include "transport/cameras/camera.h"

#include <algorithm>
#include <cmath>

#include "display/services/elementary.h"
#include "display/services/short_number.h"
#include "transport/cameras/camera_motion.h"
#include "transport/cameras/perspective.h"
#include "transport/math/matrix34.h"

namespace raylex::transport {

Camera::Camera(const Transform& camera_to_world, const Matrix4& camera_to_screen, const Vec2& pixel_size, bool has_lens)
    : world_to_camera_(camera_to_world.inverse().matrix()),
      world_to_screen_(multiply(camera_to_screen, world_to_camera_)),
      pixel_size_(pixel_size),
      has_lens_(has_lens) {}

Camera::~Camera() = default;

void Camera::generate_in_time(std::span<const CameraSample> samples, std::span<Ray> rays) const {
    generate(samples, rays);
    carry(samples, rays);
}

void Camera::carry(std::span<const CameraSample> samples, std::span<Ray> rays) const {
    for (std::size_t i = 0; i < samples.size(); ++i) rays[i].time = samples[i].time;
    if (motion_ == nullptr) return;
    for (Ray& ray : rays) {
        const Matrix34 carry = motion_->at(ray.time).to_world;
        ray.origin = carry.point(DVec3(ray.origin)).to_real();
        ray.direction = normalize(carry.vector(DVec3(ray.direction))).to_real();
    }
}

Ray Camera::generate(const CameraSample& sample) const {
    Ray ray;
    if (perspective_ == nullptr || motion_ != nullptr) {
        generate_in_time({&sample, 1}, {&ray, 1});
    } else {
        ray = perspective_->ray(sample.x, sample.y, sample.lens);
        ray.time = sample.time;
    }
    return ray;
}

[[gnu::always_inline]] inline bool Camera::connect_at_rest(const Vec3& point, const Vec2& lens,
                                                           CameraConnection& connection) const {
    return perspective_ != nullptr ? perspective_->connect_to(point, lens, connection)
                                   : connect_to(point, lens, connection);
}

[[gnu::always_inline]] inline Real Camera::importance_at_rest(const Vec3& point, const Vec3& position) const {
    return perspective_ != nullptr ? perspective_->importance_of(point, position) : importance_of(point, position);
}

void Camera::generate_weighed(std::span<const CameraSample> samples, std::span<Ray> rays,
                              std::span<Real> weights) const {
    weigh(samples, rays, weights);
    carry(samples, rays);
}

void Camera::weigh(std::span<const CameraSample> samples, std::span<Ray> rays, std::span<Real> weights) const {
    generate(samples, rays);
    std::fill(weights.begin(), weights.end(), Real(1));
}

// C = W^-1 carries the scene back, so that the camera at rest sees what the moving one sees. C multiplies a solid angle
// around the direction w by |det C| / |C w|^3. With the distances d and d |C w|, areas that face the camera give I =
// I_rest |det C| / |C w|.
Real Camera::carried_importance(const Placement& carry, const Vec3& first_point, const Vec3& first_position,
                                Real importance) const {
    const DVec3 way = DVec3(first_point) - DVec3(first_position);
    const double stretch = length(way) / length(carry.to_world.vector(way));
    return static_cast<Real>(static_cast<double>(importance) * std::abs(carry.to_object.determinant()) / stretch);
}

bool Camera::connect(const Vec3& point, const Vec2& lens, Real time, CameraConnection& connection) const {
    if (motion_ == nullptr) [[likely]]
        return connect_at_rest(point, lens, connection);
    const Placement carry = motion_->at(time);
    const Vec3 first = carry.to_object.point(DVec3(point)).to_real();
    if (!connect_at_rest(first, lens, connection)) return false;
    connection.importance = carried_importance(carry, first, connection.position, connection.importance);
    connection.position = carry.to_world.point(DVec3(connection.position)).to_real();
    return true;
}

Real Camera::importance(const Vec3& point, const Vec3& position, Real time) const {
    if (motion_ == nullptr) [[likely]]
        return importance_at_rest(point, position);
    const Placement carry = motion_->at(time);
    const Vec3 first = carry.to_object.point(DVec3(point)).to_real(),
               from = carry.to_object.point(DVec3(position)).to_real();
    return carried_importance(carry, first, from, importance_at_rest(first, from));
}

void Camera::rigid_world_to_camera(Real (&matrix)[3][4]) const {
    const Matrix34 m(world_to_camera_);
    const double scale = 1 / elementary::cbrt(std::abs(m.determinant()));
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 4; ++c) matrix[r][c] = static_cast<Real>(m.m[r][c] * scale);
}

Result<std::unique_ptr<Camera>> make_camera(const SceneEntity& entity, const CameraPlacement& placement,
                                            std::vector<Error>& warnings) {
    const std::string type = entity.type.empty() ? "perspective" : entity.type;
    const auto entry = camera_registry().require(type, entity.location);
    if (!entry) return entry.error();
    const Transform& camera_to_world = placement.camera_to_world;
    if (!camera_to_world.invertible()) return error_at(entity.location, "the camera's transform has no inverse");
    const Vec3 eye = camera_to_world.point({0, 0, 0});
    if (!(std::max({std::abs(eye.x), std::abs(eye.y), std::abs(eye.z)}) <= largest_coordinate))
        return error_at(entity.location,
                        "the camera stands at (" + short_number(eye.x, 6) + ", " + short_number(eye.y, 6) + ", " +
                            short_number(eye.z, 6) + "); expected no coordinate beyond 1e18",
                        "another unit of length brings it into range");
    auto camera = (*entry)->factory(entity, placement);
    if (!camera) return camera.error();
    warnings.insert(warnings.end(), (*camera)->warnings_.begin(), (*camera)->warnings_.end());
    (*camera)->motion_ = placement.motion;
    for (const Parameter* p : entity.parameters.unused())
        warnings.push_back(
            error_at(p->location, "camera '" + type + "' has no parameter '" + p->name + "'; it is ignored"));
    return camera;
}

}  // namespace raylex::transport
