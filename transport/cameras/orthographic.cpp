#include "transport/cameras/orthographic.h"

#include <algorithm>
#include <cmath>

#include "transport/cameras/screen_window.h"
#include "transport/math/sampling.h"

namespace raylex::transport {

Result<std::unique_ptr<Camera>> OrthographicCamera::build(const SceneEntity& entity, const CameraPlacement& placement) {
    const auto lens = read_thin_lens(entity);
    if (!lens) return lens.error();
    const auto window = read_screen_window(entity, placement);
    if (!window) return window.error();
    const std::array<double, 4>& screen = *window;
    const WindowScale scale(screen);
    const Matrix4 projection{{{scale.sx, 0, 0, scale.ox}, {0, scale.sy, 0, scale.oy}, {0, 0, 1e-3, 0}, {0, 0, 0, 1}}};
    const double step_x = (screen[1] - screen[0]) / placement.width,
                 step_y = (screen[2] - screen[3]) / placement.height;
    std::unique_ptr<OrthographicCamera> camera(
        new OrthographicCamera(placement.camera_to_world, projection,
                               {static_cast<Real>(std::abs(step_x)), static_cast<Real>(std::abs(step_y))},
                               placement.lens_code || lens->radius > 0));
    camera->corner_x_ = screen[0];
    camera->corner_y_ = screen[3];
    camera->step_x_ = step_x;
    camera->step_y_ = step_y;
    camera->lens_radius_ = std::max(lens->radius, 0.0);
    camera->focal_distance_ = lens->focal_distance;
    const double volume = std::abs(camera->placement_.to_world.determinant());
    camera->density_ = 1 / (volume * std::abs(step_x * step_y));
    camera->pixel_width_ = static_cast<Real>(
        std::sqrt(std::abs(step_x * step_y) * volume / length(camera->placement_.to_world.vector({0, 0, 1}))));
    return std::unique_ptr<Camera>(std::move(camera));
}

OrthographicCamera::OrthographicCamera(const Transform& camera_to_world, const Matrix4& projection,
                                       const Vec2& pixel_size, bool has_lens)
    : Camera(camera_to_world, projection, pixel_size, has_lens), placement_(camera_to_world) {}

void OrthographicCamera::generate(std::span<const CameraSample> samples, std::span<Ray> rays) const {
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const CameraSample& sample = samples[i];
        DVec3 origin{corner_x_ + step_x_ * double{sample.x}, corner_y_ + step_y_ * double{sample.y}, 0},
            direction{0, 0, 1};
        if (has_lens()) {
            const Vec2 d = sample_disk(sample.lens);
            const DVec3 on_lens{double{d.x} * lens_radius_, double{d.y} * lens_radius_, 0};
            origin = origin + on_lens;
            direction = direction - on_lens * (1 / focal_distance_);
        }
        rays[i] = Ray();
        rays[i].origin = placement_.to_world.point(origin).to_real();
        rays[i].direction = normalize(placement_.to_world.vector(direction)).to_real();
        rays[i].cone.width = pixel_width_;
    }
}

// From a point o of the lens (0 without a lens) around the raster position q, the ray runs through q + o + z (-o / f,
// 1). A step dq of the raster moves it by dq in every plane z. M is the linear part of camera to world, and D = M (-o /
// f, 1). An area dA that faces the ray in the world sweeps, per step of 1 in z, the volume dA |D| = |det M| dq. So
//     d(raster) / dA = |D| / (|det M| pixel_area).
bool OrthographicCamera::connect_to(const Vec3& point, const Vec2& lens, CameraConnection& connection) const {
    const DVec3 seen = placement_.to_object.point(DVec3(point));
    if (!(seen.z > 0)) return false;
    DVec3 on_lens;
    if (has_lens()) {
        const Vec2 d = sample_disk(lens);
        on_lens = {double{d.x} * lens_radius_, double{d.y} * lens_radius_, 0};
    }
    const DVec3 on_film = DVec3{seen.x, seen.y, 0} - on_lens * (1 - seen.z / focal_distance_);
    connection.position = placement_.to_world.point(on_film + on_lens).to_real();
    connection.x = static_cast<Real>((on_film.x - corner_x_) / step_x_);
    connection.y = static_cast<Real>((on_film.y - corner_y_) / step_y_);
    connection.importance = importance_of(point, connection.position);
    return true;
}

Real OrthographicCamera::importance_of(const Vec3& point, const Vec3& position) const {
    const DVec3 way = DVec3(point) - DVec3(position);
    const double depth = placement_.to_object.vector(way).z;
    return depth > 0 ? static_cast<Real>(density_ * length(way) / depth) : Real(0);
}

}  // namespace raylex::transport
