// The functions of a camera agree, and the registry makes cameras.
#include <catch2/catch.hpp>

#include <cmath>

#include "transport/cameras/camera.h"

using namespace raylex;

namespace {

transport::SceneEntity thin_lens() {
    transport::SceneEntity entity;
    entity.type = "perspective";
    for (const auto& [name, value] :
         {std::pair("fov", 40.0), std::pair("lensradius", 0.2), std::pair("focaldistance", 3.0)}) {
        Parameter parameter;
        parameter.name = name;
        parameter.type = ParameterType::real;
        parameter.numbers = {value};
        entity.parameters.parameters.push_back(parameter);
    }
    return entity;
}

transport::CameraPlacement aside() {
    return {transport::Transform::look_at({1, 2, 3}, {0, 0.5, -1}, {0, 1, 0}).inverse(), 64, 48};
}

}  // namespace

TEST_CASE("a camera connects a point of its ray to the ray's raster position, singly and in batches", "[camera]") {
    std::vector<Error> warnings;
    const auto camera = transport::make_camera(thin_lens(), aside(), warnings);
    REQUIRE(camera.ok());
    CHECK(warnings.empty());
    REQUIRE((*camera)->has_lens());
    std::vector<transport::CameraSample> samples;
    for (int i = 0; i < 20; ++i) {
        const auto t = static_cast<float>(i) / 20;
        samples.push_back({64 * t, 48 * (1 - t), {t, std::fmod(3 * t, 1.0f)}});
    }
    std::vector<transport::Ray> rays(samples.size());
    (*camera)->generate(samples, rays);
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const transport::CameraSample& sample = samples[i];
        const transport::Ray one = (*camera)->generate(sample);
        CHECK((one.origin == rays[i].origin && one.direction == rays[i].direction));
        transport::CameraConnection seen;
        const transport::Vec3 point = one.origin + one.direction * 5;
        REQUIRE((*camera)->connect(point, sample.lens, 0, seen));
        CHECK(seen.x == Approx(sample.x).margin(1e-3));
        CHECK(seen.y == Approx(sample.y).margin(1e-3));
        CHECK((*camera)->importance(point, seen.position, 0) == seen.importance);
        CHECK_FALSE((*camera)->connect(one.origin - one.direction * 5, sample.lens, 0, seen));
    }
}

TEST_CASE("rays have valid directions for every focal distance and unit of length", "[camera]") {
    const auto rays_of = [](double focus, double unit) {
        transport::SceneEntity entity = thin_lens();
        entity.parameters.parameters.back().numbers = {focus};
        transport::CameraPlacement placement = aside();
        placement.camera_to_world = placement.camera_to_world * transport::Transform::scale(unit, unit, unit);
        std::vector<Error> warnings;
        const auto camera = transport::make_camera(entity, placement, warnings);
        REQUIRE(camera.ok());
        std::vector<transport::Ray> rays;
        for (int i = 0; i < 20; ++i) {
            const auto t = static_cast<float>(i) / 20;
            rays.push_back((*camera)->generate(transport::CameraSample{64 * t, 48 * (1 - t), {t, t * t}}));
        }
        return rays;
    };
    // From 1e6 on all rays of a pixel are parallel in float.
    const std::vector<transport::Ray> far = rays_of(1e9, 1);
    for (const auto& [focus, unit] : {std::pair(1e18, 1.0), std::pair(3e19, 1.0), std::pair(3.4e38, 1.0),
                                      std::pair(1e9, 1e-20), std::pair(1e9, 1e20), std::pair(1e9, 1e-35)}) {
        CAPTURE(focus, unit);
        const std::vector<transport::Ray> rays = rays_of(focus, unit);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            CHECK(length(rays[i].direction) == Approx(1));
            CHECK(length(rays[i].direction - far[i].direction) < 1e-6f);
        }
    }
}

TEST_CASE("invalid cameras are errors that name the cause, and unknown parameters are warnings", "[camera]") {
    std::vector<Error> warnings;
    transport::SceneEntity entity = thin_lens();
    entity.parameters.parameters[2].name = "focaldistence";
    REQUIRE(transport::make_camera(entity, aside(), warnings).ok());
    REQUIRE(warnings.size() == 1);
    CHECK(warnings[0].message == "camera 'perspective' has no parameter 'focaldistence'; it is ignored");
    entity.type = "perspektive";
    const auto unknown = transport::make_camera(entity, aside(), warnings);
    REQUIRE_FALSE(unknown.ok());
    CHECK(unknown.error().hint == "did you mean 'perspective'?");
    transport::CameraPlacement flat = aside();
    flat.camera_to_world = transport::Transform::scale(1, 0, 1);
    const auto refused = transport::make_camera(thin_lens(), flat, warnings);
    REQUIRE_FALSE(refused.ok());
    CHECK(refused.error().message == "the camera's transform has no inverse");
}
