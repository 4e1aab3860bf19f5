#include "transport/cameras/camera.h"

#include <algorithm>
#include <cmath>

#include "display/services/elementary.h"
#include "transport/cameras/perspective.h"
#include "transport/geometry/matrix34.h"

namespace raylex::transport {
namespace {

Matrix4 multiply(const Matrix4& a, const Matrix4& b) {
    Matrix4 product{};
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < 4; ++j)
            for (std::size_t k = 0; k < 4; ++k) product[i][j] += a[i][k] * b[k][j];
    return product;
}

}  // namespace

Camera::Camera(const Transform& camera_to_world, const Matrix4& camera_to_screen, const Vec2& pixel_size, bool has_lens)
    : world_to_camera_(camera_to_world.inverse().matrix()),
      world_to_screen_(multiply(camera_to_screen, world_to_camera_)),
      pixel_size_(pixel_size),
      has_lens_(has_lens) {}

Ray Camera::generate(Real x, Real y, const Vec2& lens) const {
    if (perspective_ != nullptr) return perspective_->ray(x, y, lens);
    const CameraSample sample{x, y, lens};
    Ray ray;
    generate({&sample, 1}, {&ray, 1});
    return ray;
}

bool Camera::connect(const Vec3& point, const Vec2& lens, CameraConnection& connection) const {
    return perspective_ != nullptr ? perspective_->connect_to(point, lens, connection)
                                   : connect_to(point, lens, connection);
}

Real Camera::importance(const Vec3& point, const Vec3& position) const {
    return perspective_ != nullptr ? perspective_->importance_of(point, position) : importance_of(point, position);
}

void Camera::generate_weighed(std::span<const CameraSample> samples, std::span<Ray> rays,
                              std::span<Real> weights) const {
    generate(samples, rays);
    std::fill(weights.begin(), weights.end(), Real(1));
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
                        "the camera stands at (" + std::to_string(eye.x) + ", " + std::to_string(eye.y) + ", " +
                            std::to_string(eye.z) + "); expected no coordinate beyond 1e18",
                        "another unit of length brings it into range");
    auto camera = (*entry)->factory(entity, placement);
    if (!camera) return camera.error();
    warnings.insert(warnings.end(), (*camera)->warnings_.begin(), (*camera)->warnings_.end());
    for (const Parameter* p : entity.parameters.unused())
        warnings.push_back(
            error_at(p->location, "camera '" + type + "' has no parameter '" + p->name + "'; it is ignored"));
    return camera;
}

}  // namespace raylex::transport
