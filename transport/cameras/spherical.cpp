#include "transport/cameras/spherical.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "display/services/elementary.h"
#include "transport/math/octahedral.h"

namespace raylex::transport {
namespace {

constexpr double half_turn = std::numbers::pi;

/// Wraps a point beside the unit square to the point of the square where the sphere continues.
Vec2 wrapped_square(double x, double y) {
    if (x < 0 || x > 1) {
        x = x < 0 ? -x : 2 - x;
        y = 1 - y;
    }
    if (y < 0 || y > 1) {
        y = y < 0 ? -y : 2 - y;
        x = 1 - x;
    }
    return {static_cast<Real>(x), static_cast<Real>(y)};
}

}  // namespace

Result<std::unique_ptr<Camera>> SphericalCamera::build(const SceneEntity& entity, const CameraPlacement& placement) {
    auto mapping = entity.parameters.string_or("mapping", "equalarea");
    if (!mapping) return mapping.error();
    if (*mapping != "equalarea" && *mapping != "equirectangular")
        return error_at(entity.location, "'mapping' is '" + *mapping + "'; expected equalarea or equirectangular");
    return std::unique_ptr<Camera>(new SphericalCamera(placement, *mapping == "equalarea"));
}

SphericalCamera::SphericalCamera(const CameraPlacement& placement, bool equal_area)
    // No matrix takes all directions to a screen, so the image header contains none.
    : Camera(placement.camera_to_world, Matrix4{},
             {static_cast<Real>(2 * half_turn / placement.width), static_cast<Real>(half_turn / placement.height)},
             false),
      placement_(placement.camera_to_world),
      origin_(placement_.to_world.point({0, 0, 0})),
      width_(placement.width),
      height_(placement.height),
      equal_area_(equal_area) {}

void SphericalCamera::generate(std::span<const CameraSample> samples, std::span<Ray> rays) const {
    const Real spread = static_cast<Real>(std::sqrt(4 * half_turn / (width_ * height_)));
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const double x = double{samples[i].x} / width_, y = double{samples[i].y} / height_;
        DVec3 direction;
        if (equal_area_) {
            const DVec3 d(direction_from_octahedral(wrapped_square(x, y)));
            direction = {d.x, d.z, d.y};
        } else {
            const auto theta = elementary::sin_cos(y * half_turn), phi = elementary::sin_cos(x * 2 * half_turn);
            direction = {theta.sin * phi.cos, theta.cos, theta.sin * phi.sin};
        }
        rays[i] = Ray();
        rays[i].origin = origin_.to_real();
        rays[i].direction = normalize(placement_.to_world.vector(direction)).to_real();
        rays[i].cone.spread = spread;
    }
}

bool SphericalCamera::connect_to(const Vec3& point, const Vec2&, CameraConnection& connection) const {
    const DVec3 way = DVec3(point) - origin_;
    if (!(length(way) > 0)) return false;
    const DVec3 d = normalize(placement_.to_object.vector(way));
    connection.position = origin_.to_real();
    if (equal_area_) {
        const Vec2 at =
            octahedral_from_direction({static_cast<Real>(d.x), static_cast<Real>(d.z), static_cast<Real>(d.y)});
        connection.x = at.x * static_cast<Real>(width_);
        connection.y = at.y * static_cast<Real>(height_);
    } else {
        const double phi = elementary::atan2(d.z, d.x);
        connection.x = static_cast<Real>((phi < 0 ? phi + 2 * half_turn : phi) / (2 * half_turn) * width_);
        connection.y = static_cast<Real>(elementary::acos(std::clamp(d.y, -1.0, 1.0)) / half_turn * height_);
    }
    connection.importance = importance_of(point, connection.position);
    return true;
}

/// Pixels per steradian over the squared distance. A transform that stretches multiplies the solid angle around a unit
/// direction d of camera space by |det M| / |M d|^3 in the world.
Real SphericalCamera::importance_of(const Vec3& point, const Vec3&) const {
    const DVec3 way = DVec3(point) - origin_, local = placement_.to_object.vector(way);
    const double distance = length(way), unit = length(local);
    if (!(distance > 0)) return 0;
    const double stretch = distance / unit;  // |M d|
    const double angle = stretch * stretch * stretch / std::abs(placement_.to_world.determinant());
    double pixels = width_ * height_ / (4 * half_turn);
    if (!equal_area_) {
        const double y = local.y / unit, sine = std::sqrt(std::max(0.0, 1 - y * y));
        if (!(sine > 0)) return 0;
        pixels = width_ * height_ / (2 * half_turn * half_turn * sine);
    }
    return static_cast<Real>(pixels * angle / (distance * distance));
}

}  // namespace raylex::transport
