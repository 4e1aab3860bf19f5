// A camera: parallel rays, so that things are as large as they are, whatever their distance.
#include <cmath>
#include <cstdlib>

#include "transport/plugins/plugin.h"

namespace {

using namespace raylex;
using namespace raylex::transport;

/// Camera space to the screen: the window of these half sizes, and depths up to 1000.
Matrix4 projection_of(double half_width, double half_height) {
    return {{{1 / half_width, 0, 0, 0}, {0, 1 / half_height, 0, 0}, {0, 0, 1e-3, 0}, {0, 0, 0, 1}}};
}

class Orthographic final : public Camera {
  public:
    Orthographic(const CameraPlacement& at, double half_width, double half_height)
        : Camera(at.camera_to_world, projection_of(half_width, half_height),
                 {static_cast<float>(2 * half_width / at.width), static_cast<float>(2 * half_height / at.height)},
                 false),
          to_world_(at.camera_to_world),
          to_camera_(at.camera_to_world.inverse()),
          corner_{static_cast<float>(-half_width), static_cast<float>(half_height), 0},
          direction_(normalize(at.camera_to_world.vector({0, 0, 1}))) {
        const Vec3 x = to_world_.vector({pixel_size().x, 0, 0}), y = to_world_.vector({0, pixel_size().y, 0});
        pixels_per_area_ = 1 / std::abs(dot(cross(x, y), direction_));
    }

    using Camera::generate;
    void generate(std::span<const CameraSample> samples, std::span<Ray> rays) const override {
        for (std::size_t i = 0; i < samples.size(); ++i) {
            rays[i].origin = to_world_.point(
                {corner_.x + samples[i].x * pixel_size().x, corner_.y - samples[i].y * pixel_size().y, 0});
            rays[i].direction = direction_;
        }
    }

  private:
    bool connect_to(const Vec3& point, const Vec2& /*lens*/, CameraConnection& connection) const override {
        const Vec3 seen = to_camera_.point(point);
        connection.position = to_world_.point({seen.x, seen.y, 0});
        connection.x = (seen.x - corner_.x) / pixel_size().x;
        connection.y = (corner_.y - seen.y) / pixel_size().y;
        connection.importance = pixels_per_area_;
        return seen.z > 0;
    }
    float importance_of(const Vec3& point, const Vec3& /*position*/) const override {
        return to_camera_.point(point).z > 0 ? pixels_per_area_ : 0.0f;
    }

    Transform to_world_, to_camera_;
    Vec3 corner_;            // camera space: raster (0, 0)
    Vec3 direction_;         // world
    float pixels_per_area_;  // across the rays, world
};

Result<std::unique_ptr<Camera>> make_orthographic(const SceneEntity& entity, const CameraPlacement& at) {
    auto extent = entity.parameters.real_or("extent", 1);
    if (!extent) return extent.error();
    if (!(*extent > 0))
        return error_at(entity.location,
                        "'extent' is " + std::to_string(std::lround(*extent)) + "; expected a positive length");
    const double aspect = static_cast<double>(at.width) / at.height;
    return std::unique_ptr<Camera>(
        std::make_unique<Orthographic>(at, *extent * std::max(1.0, aspect), *extent * std::max(1.0, 1 / aspect)));
}

}  // namespace

RAYLEX_PLUGIN(host) {
    host.add_camera({"parallel",
                     "parallel rays: size does not depend on distance",
                     {{"extent", ParameterType::real, "1", "half of the image's shorter side, in camera space"}},
                     make_orthographic});
}
