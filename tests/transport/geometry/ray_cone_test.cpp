// Times and cones along rays: no renderer reads them yet, so only this test checks that they are passed on.
#include <catch2/catch.hpp>
#include <utility>
#include <vector>

#include "transport/cameras/camera.h"
#include "transport/embree/embree_scene.h"
#include "transport/import/pbrt/pbrt_importer.h"
#include "transport/paths/vertex.h"

using namespace raylex;

TEST_CASE("hits and leaving rays keep the time, and the cone widens with the distance", "[geometry]") {
    auto scene = transport::import_pbrt_text(R"(
WorldBegin
Shape "sphere" "float radius" 1
)",
                                             "cone.pbrt");
    REQUIRE(scene.ok());
    transport::TextureTable textures;
    auto geometry = transport::EmbreeScene::build(*scene, textures, {});
    REQUIRE(geometry.ok());
    transport::Ray ray;
    ray.origin = {0, 0, 5};
    ray.direction = {0, 0, -1};
    ray.time = 0.25f;
    ray.cone = {0.125f, 0.5f};
    transport::VertexBatch vertices;
    vertices.reserve(1);
    geometry->intersect({&ray, 1}, vertices.hits);
    REQUIRE(vertices.hits[0].valid());
    const transport::Ray next = transport::ray_from(vertices, 0, {0, 0, 1});
    for (const auto& [time, cone] :
         {std::pair{vertices.hits[0].time, vertices.hits[0].cone}, std::pair{next.time, next.cone}}) {
        CHECK(time == 0.25f);
        CHECK(cone.width == 0.125f + 0.5f * vertices.hits[0].t);
        CHECK(cone.spread == 0.5f);
    }
}

TEST_CASE("camera rays begin with the angle of a pixel", "[camera]") {
    // 90 degrees over 64 pixels: 2 / 64 on the plane at distance 1.
    std::vector<Error> warnings;
    const auto camera = transport::make_camera({}, {transport::Transform(), 64, 64}, warnings);
    REQUIRE(camera.ok());
    const transport::Ray ray = (*camera)->generate({32, 32, {0.5f, 0.5f}});
    CHECK(ray.cone.width == 0);
    CHECK(ray.cone.spread == Approx(2.0 / 64));
    CHECK(ray.time == 0);
}
