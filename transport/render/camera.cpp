#include "transport/render/camera.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "transport/geometry/matrix34.h"
#include "transport/math/sampling.h"

namespace raylex::transport {
namespace {

void warn_unused(const SceneEntity& entity, const std::string& kind, std::vector<Error>& warnings) {
    for (const Parameter* p : entity.parameters.unused())
        warnings.push_back(error_at(p->location, kind + " has no parameter '" + p->name + "'; it is ignored"));
}

Matrix4 multiply(const Matrix4& a, const Matrix4& b) {
    Matrix4 product{};
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < 4; ++j)
            for (std::size_t k = 0; k < 4; ++k) product[i][j] += a[i][k] * b[k][j];
    return product;
}

}  // namespace

Result<PerspectiveCamera> PerspectiveCamera::build(const SceneEntity& entity, const Transform& camera_to_world,
                                                   int width, int height, std::vector<Error>& warnings) {
    if (!entity.type.empty() && entity.type != "perspective")
        return error_at(entity.location, "camera '" + entity.type + "' is not supported; expected 'perspective'");
    if (!camera_to_world.invertible()) return error_at(entity.location, "the camera's transform has no inverse");
    const ParameterSet& set = entity.parameters;
    auto fov = set.real_or("fov", 90), lens = set.real_or("lensradius", 0), focus = set.real_or("focaldistance", 1e6);
    auto aspect = set.real_or("frameaspectratio", static_cast<double>(width) / height);
    for (const auto* each : {&fov, &lens, &focus, &aspect})
        if (!*each) return each->error();
    if (!(*fov > 0 && *fov < 180))
        return error_at(entity.location, "'fov' is " + std::to_string(*fov) + "; expected degrees between 0 and 180");
    if (!(*aspect > 0)) return error_at(entity.location, "'frameaspectratio' must be positive");
    if (!(*focus > 0)) return error_at(entity.location, "'focaldistance' must be positive");
    std::array<double, 4> screen = *aspect > 1 ? std::array<double, 4>{-*aspect, *aspect, -1, 1}
                                               : std::array<double, 4>{-1, 1, -1 / *aspect, 1 / *aspect};
    if (const Parameter* p = set.find("screenwindow")) {
        if (p->numbers.size() != 4)
            return error_at(p->location, "'screenwindow' must be four numbers: x min, x max, y min, y max");
        for (std::size_t i = 0; i < 4; ++i) screen[i] = p->numbers[i];
    }
    warn_unused(entity, "the perspective camera", warnings);
    const Vec3 eye = camera_to_world.point({0, 0, 0});
    if (!(std::max({std::abs(eye.x), std::abs(eye.y), std::abs(eye.z)}) <= largest_coordinate))
        return error_at(entity.location, "the camera stands at (" + std::to_string(eye.x) + ", " + std::to_string(eye.y) + ", " +
                                             std::to_string(eye.z) + "); expected no coordinate beyond 1e18",
                        "another unit of length brings it into range");

    PerspectiveCamera camera;
    camera.camera_to_world_ = camera_to_world;
    camera.origin_ = camera_to_world.point({0, 0, 0});
    camera.lens_radius_ = static_cast<Real>(std::max(*lens, 0.0));
    camera.focal_distance_ = static_cast<Real>(*focus);
    const double tangent = std::tan(*fov * 3.14159265358979323846 / 360);
    camera.corner_ = DVec3{screen[0] * tangent, screen[3] * tangent, 1}.to_real();
    camera.step_x_ = DVec3{(screen[1] - screen[0]) * tangent / width, 0, 0}.to_real();
    camera.step_y_ = DVec3{0, (screen[2] - screen[3]) * tangent / height, 0}.to_real();

    camera.pixel_angle_ = std::sqrt(std::abs(camera.step_x_.x * camera.step_y_.y));

    camera.world_to_camera_ = camera_to_world.inverse().matrix();
    camera.to_camera_ = Matrix34(camera.world_to_camera_);
    camera.raster_density_ = std::abs(camera.to_camera_.determinant() /
                                      (static_cast<double>(camera.step_x_.x) * static_cast<double>(camera.step_y_.y)));
    const double near = 1e-2, far = 1e3;
    const double sx = 2 / ((screen[1] - screen[0]) * tangent), sy = 2 / ((screen[3] - screen[2]) * tangent);
    const double ox = -(screen[1] + screen[0]) / (screen[1] - screen[0]),
                 oy = -(screen[3] + screen[2]) / (screen[3] - screen[2]);
    const Matrix4 projection{
        {{sx, 0, ox, 0}, {0, sy, oy, 0}, {0, 0, far / (far - near), -far * near / (far - near)}, {0, 0, 1, 0}}};
    camera.world_to_screen_ = multiply(projection, camera.world_to_camera_);
    return camera;
}

Ray PerspectiveCamera::generate(Real x, Real y, const Vec2& lens) const {
    const Vec3 through{corner_.x + step_x_.x * x, corner_.y + step_y_.y * y, 1};
    Ray ray;
    ray.cone.spread = pixel_angle_;
    if (!has_lens()) {
        ray.origin = origin_;
        ray.direction = normalize(camera_to_world_.vector(through));
        return ray;
    }
    // Every point of the lens sees the plane z = focal distance in the same place.
    const Vec2 d = sample_disk(lens);
    const Vec3 on_lens{d.x * lens_radius_, d.y * lens_radius_, 0};
    ray.origin = camera_to_world_.point(on_lens);
    ray.direction = normalize(camera_to_world_.vector(through * focal_distance_ - on_lens));
    return ray;
}

// A raster position r and a point of the lens o give the direction D(r) = M (f q(r) - o), where q(r) lies on the plane
// at distance 1, f is the focal distance and M the linear part of camera to world. Then
//     d(omega)/d(r) = |det(D, D_x, D_y)| / |D|^3 = |det M| f^3 pixel_area / |D|^3,
// and a point at p in camera space, seen from o, lies on D at |D| = distance f / (p - o)_z. The measurement is a mean
// over the lens, from which o is drawn, so that densities of o cancel.
bool PerspectiveCamera::connect(const Vec3& point, const Vec2& lens, CameraConnection& connection) const {
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

Real PerspectiveCamera::importance(const Vec3& point, const Vec3& position) const {
    const double depth = to_camera_.point(DVec3(point)).z;  // the lens is at depth 0
    return depth > 0 ? importance_at(depth, point, position) : 0.0f;
}

void PerspectiveCamera::rigid_world_to_camera(Real (&matrix)[3][4]) const {
    const Matrix34 m(world_to_camera_);
    const double scale = 1 / std::cbrt(std::abs(m.determinant()));
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 4; ++c) matrix[r][c] = static_cast<Real>(m.m[r][c] * scale);
}

Result<FilmSettings> read_film(const SceneEntity& film, const std::optional<std::array<int, 2>>& resolution,
                               std::vector<Error>& warnings) {
    FilmSettings settings;
    const ParameterSet& set = film.parameters;
    auto width = set.integer_or("xresolution", settings.width), height = set.integer_or("yresolution", settings.height);
    if (!width) return width.error();
    if (!height) return height.error();
    if (resolution) {
        *width = (*resolution)[0];
        *height = (*resolution)[1];
    }
    if (*width < 1 || *height < 1 || *width > 65536 || *height > 65536)
        return error_at(film.location, "the resolution is " + std::to_string(*width) + " x " + std::to_string(*height) +
                                           "; expected 1 to 65536 pixels each way");
    settings.width = static_cast<int>(*width);
    settings.height = static_cast<int>(*height);
    for (const char* name : {"cropwindow", "pixelbounds"})
        if (const Parameter* p = set.find(name))
            return error_at(p->location, std::string("'") + name + "' is not supported yet; expected the whole image");
    if (!film.type.empty() && film.type != "rgb")
        warnings.push_back(
            error_at(film.location, "film '" + film.type + "' is written as plain radiance, as film 'rgb'"));
    // Where the image goes is said beside the scene, and a pinhole or thin lens does not ask for the film's size.
    for (const char* name : {"filename", "diagonal"}) static_cast<void>(set.find(name));
    warn_unused(film, "the film", warnings);
    return settings;
}

}  // namespace raylex::transport
