#include "transport/cameras/perspective.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "display/services/elementary.h"
#include "display/services/short_number.h"
#include "transport/cameras/screen_window.h"
#include "transport/math/sampling.h"

namespace raylex::transport {
namespace {

/// The largest power of two that is at most `value` > 0: dividing by it is exact.
double power_below(double value) {
    return std::isfinite(value) && value > 0 ? std::ldexp(1.0, std::ilogb(value)) : 1;
}

/// The transform of directions, in another unit of length: their squares are floats for every scale of the camera.
Transform for_directions(const Transform& camera_to_world) {
    Matrix4 m = camera_to_world.matrix();
    double largest = 0;
    for (std::size_t r = 0; r < 3; ++r)
        for (std::size_t c = 0; c < 3; ++c) largest = std::max(largest, std::abs(m[r][c]));
    const double unit = power_below(largest);
    for (std::size_t r = 0; r < 3; ++r) {
        for (std::size_t c = 0; c < 3; ++c) m[r][c] /= unit;
        m[r][3] = 0;
    }
    return Transform(m);
}

}  // namespace

Result<std::unique_ptr<Camera>> PerspectiveCamera::build(const SceneEntity& entity, const CameraPlacement& placement) {
    const int width = placement.width, height = placement.height;
    auto fov = entity.parameters.real_or("fov", 90);
    if (!fov) return fov.error();
    if (!(*fov > 0 && *fov < 180))
        return error_at(entity.location, "'fov' is " + short_number(*fov, 6) + "; expected degrees between 0 and 180");
    const auto lens = read_thin_lens(entity);
    if (!lens) return lens.error();
    const auto window = read_screen_window(entity, placement);
    if (!window) return window.error();
    const std::array<double, 4>& screen = *window;
    const double tangent = elementary::tan(*fov * std::numbers::pi / 360);
    const Vec3 step_x = DVec3{(screen[1] - screen[0]) * tangent / width, 0, 0}.to_real(),
               step_y = DVec3{0, (screen[2] - screen[3]) * tangent / height, 0}.to_real();
    const double near = 1e-2, far = 1e3;
    const WindowScale scale(screen, tangent);
    const Matrix4 projection{{{scale.sx, 0, scale.ox, 0},
                              {0, scale.sy, scale.oy, 0},
                              {0, 0, far / (far - near), -far * near / (far - near)},
                              {0, 0, 1, 0}}};

    std::unique_ptr<PerspectiveCamera> camera(
        new PerspectiveCamera(placement.camera_to_world, projection, {std::abs(step_x.x), std::abs(step_y.y)},
                              placement.lens_code || static_cast<Real>(lens->radius) > 0));
    camera->step_x_ = step_x;
    camera->step_y_ = step_y;
    camera->corner_ = DVec3{screen[0] * tangent, screen[3] * tangent, 1}.to_real();
    camera->lens_radius_ = static_cast<Real>(std::max(lens->radius, 0.0));
    camera->focal_distance_ = static_cast<Real>(lens->focal_distance);
    const double focal_unit = power_below(lens->focal_distance);
    camera->focal_in_unit_ = static_cast<Real>(lens->focal_distance / focal_unit);
    camera->lens_in_unit_ = static_cast<Real>(std::max(lens->radius, 0.0) / focal_unit);
    camera->raster_density_ =
        std::abs(camera->to_camera_.determinant() / (static_cast<double>(step_x.x) * static_cast<double>(step_y.y)));
    return std::unique_ptr<Camera>(std::move(camera));
}

PerspectiveCamera::PerspectiveCamera(const Transform& camera_to_world, const Matrix4& projection,
                                     const Vec2& pixel_size, bool has_lens)
    : Camera(camera_to_world, projection, pixel_size, has_lens),
      camera_to_world_(camera_to_world),
      for_directions_(for_directions(camera_to_world)),
      origin_(camera_to_world.point({0, 0, 0})),
      pixel_angle_(std::sqrt(pixel_size.x * pixel_size.y)),
      to_camera_(world_to_camera()) {
    perspective_ = this;
}

void PerspectiveCamera::generate(std::span<const CameraSample> samples, std::span<Ray> rays) const {
    for (std::size_t i = 0; i < samples.size(); ++i) rays[i] = ray(samples[i].x, samples[i].y, samples[i].lens);
}

Ray PerspectiveCamera::ray(Real x, Real y, const Vec2& lens) const {
    const Vec3 through{corner_.x + step_x_.x * x, corner_.y + step_y_.y * y, 1};
    Ray ray;
    ray.cone.spread = pixel_angle_;
    if (!has_lens()) {
        ray.origin = origin_;
        ray.direction = normalize(for_directions_.vector(through));
        return ray;
    }
    // All points of the lens see the plane z = focal distance in the same place.
    const Vec2 d = sample_disk(lens);
    const Vec3 on_lens{d.x * lens_radius_, d.y * lens_radius_, 0};
    ray.origin = camera_to_world_.point(on_lens);
    const Vec3 in_unit{d.x * lens_in_unit_, d.y * lens_in_unit_, 0};
    ray.direction = normalize(for_directions_.vector(lens_radius_ > 0 ? through * focal_in_unit_ - in_unit : through));
    return ray;
}

// A raster position r and a point of the lens o give the direction D(r) = M (f q(r) - o), where q(r) lies on the plane
// at distance 1, f is the focal distance and M the linear part of camera to world. Then
//     d(omega)/d(r) = |det(D, D_x, D_y)| / |D|^3 = |det M| f^3 pixel_area / |D|^3,
// and a point at p in camera space, seen from o, lies on D at |D| = distance f / (p - o)_z. The measurement is a mean
// over the lens, from which o is drawn, so that densities of o cancel.
bool PerspectiveCamera::connect_to(const Vec3& point, const Vec2& lens, CameraConnection& connection) const {
    DVec3 seen = to_camera_.point(DVec3(point));
    if (!(seen.z > 0)) return false;
    double at_x = seen.x / seen.z, at_y = seen.y / seen.z;
    connection.position = origin_;
    if (has_lens()) {
        const Vec2 d = sample_disk(lens);
        const Vec3 on_lens{d.x * lens_radius_, d.y * lens_radius_, 0};
        connection.position = camera_to_world_.point(on_lens);
        seen = seen - DVec3(on_lens);
        const double focal = static_cast<double>(focal_distance_);
        at_x = seen.x / seen.z + static_cast<double>(on_lens.x) / focal;
        at_y = seen.y / seen.z + static_cast<double>(on_lens.y) / focal;
    }
    connection.x = static_cast<Real>((at_x - static_cast<double>(corner_.x)) / static_cast<double>(step_x_.x));
    connection.y = static_cast<Real>((at_y - static_cast<double>(corner_.y)) / static_cast<double>(step_y_.y));
    connection.importance = importance_at(seen.z, point, connection.position);
    return true;
}

Real PerspectiveCamera::importance_at(double depth, const Vec3& point, const Vec3& position) const {
    return static_cast<Real>(raster_density_ * length(DVec3(point) - DVec3(position)) / (depth * depth * depth));
}

Real PerspectiveCamera::importance_of(const Vec3& point, const Vec3& position) const {
    const double depth = to_camera_.point(DVec3(point)).z;  // the lens is at depth 0
    return depth > 0 ? importance_at(depth, point, position) : Real(0);
}

}  // namespace raylex::transport
