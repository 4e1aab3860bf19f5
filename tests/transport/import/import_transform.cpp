// pbrt's conventions: composition order, column-wise matrices, left-handed LookAt, handedness and normals.
#include <catch2/catch.hpp>

#include <random>

#include "tests/transport/import_support.h"

using namespace import_test;
using namespace raylex::transport;

namespace {

// Coordinates of size 10 in float have an error of 1e-6; products of a few of them stay below 1e-5.
void check_close(const Vec3& a, const Vec3& b, float tolerance = 1e-5f) {
    INFO(a.x << " " << a.y << " " << a.z << " against " << b.x << " " << b.y << " " << b.z);
    CHECK(length(a - b) <= tolerance);
}

Matrix4 random_matrix(std::mt19937& random) {
    std::uniform_real_distribution<double> value(-2, 2);
    Matrix4 m{};
    for (std::size_t i = 0; i < 3; ++i)
        for (double& entry : m[i]) entry = value(random);
    m[3] = {0, 0, 0, 1};
    return m;
}

}  // namespace

TEST_CASE("LookAt is left-handed: looking down -z, +x is on the image's left", "[transform]") {
    const SceneDescription scene = scene_of("LookAt 0 1 4  0 1 0  0 1 0 Camera \"perspective\" WorldBegin");
    check_close(scene.camera_to_world.point({0, 0, 0}), {0, 1, 4});
    check_close(scene.camera_to_world.vector({0, 0, 1}), {0, 0, -1});
    check_close(scene.camera_to_world.vector({0, 1, 0}), {0, 1, 0});
    check_close(scene.camera_to_world.vector({1, 0, 0}), {-1, 0, 0});  // camera +x (image right) is world -x
}

TEST_CASE("a leading Scale -1 1 1 mirrors the image", "[transform]") {
    const SceneDescription scene =
        scene_of("Scale -1 1 1 LookAt 0 1 4  0 1 0  0 1 0 Camera \"perspective\" WorldBegin");
    check_close(scene.camera_to_world.vector({1, 0, 0}), {1, 0, 0});
    check_close(scene.camera_to_world.vector({0, 0, 1}), {0, 0, -1});
}

TEST_CASE("the last transformation written acts first", "[transform]") {
    const SceneDescription scene = scene_of(
        "WorldBegin Translate 10 0 0 Rotate 90 0 0 1 Scale 2 1 1\n"
        "Shape \"trianglemesh\" \"point3 P\" [1 0 0  0 1 0  0 0 1]");
    CHECK(placed(scene.shapes[0]).positions[0] == Vec3{10, 2, 0});  // multiples of 90 degrees are exact
    CHECK(placed(scene.shapes[0]).positions[1] == Vec3{9, 0, 0});
}

TEST_CASE("matrices are written column by column; Transform replaces and ConcatTransform composes", "[transform]") {
    const SceneDescription scene = scene_of(
        "WorldBegin Scale 5 5 5 Transform [1 0 0 0  0 1 0 0  0 0 1 0  7 8 9 1] ConcatTransform [2 0 0 0  0 2 0 0  0 0 "
        "2 0  0 0 0 1]\n"
        "Shape \"trianglemesh\" \"point3 P\" [1 0 0  0 1 0  0 0 1]");
    CHECK(placed(scene.shapes[0]).positions[0] == Vec3{9, 8, 9});
}

TEST_CASE("CoordSysTransform returns to the camera's and to a named system", "[transform]") {
    const SceneDescription scene = scene_of(
        "Translate 0 0 -4 Camera \"perspective\" WorldBegin Translate 1 0 0 CoordinateSystem \"mark\" Identity\n"
        "CoordSysTransform \"camera\" Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0]\n"
        "CoordSysTransform \"mark\" Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0]\n"
        "CoordSysTransform \"world\" Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0]");
    CHECK(placed(scene.shapes[0]).positions[0] == Vec3{0, 0, 4});
    CHECK(placed(scene.shapes[1]).positions[0] == Vec3{1, 0, 0});
    CHECK(placed(scene.shapes[2]).positions[0] == Vec3{0, 0, 0});
}

TEST_CASE("a transform that moves and moves back is not a motion", "[transform]") {
    const SceneDescription scene = scene_of(
        "WorldBegin ActiveTransform StartTime Translate 1 0 0 ActiveTransform EndTime Translate 1 0 0\n"
        "ActiveTransform All Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0]");
    CHECK(placed(scene.shapes[0]).positions[0] == Vec3{1, 0, 0});
}

TEST_CASE("the surface side flips under ReverseOrientation xor mirroring", "[transform]") {
    const auto flipped = [](const std::string& before) {
        const SceneDescription scene = scene_of(
            "WorldBegin " + before + " Shape \"sphere\" Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0]");
        CHECK(scene.shapes[0].flip_normal == scene.shapes[1].flip_normal);
        return scene.shapes[0].flip_normal;
    };
    CHECK_FALSE(flipped(""));
    CHECK(flipped("ReverseOrientation"));
    CHECK(flipped("Scale 1 -1 1"));
    CHECK_FALSE(flipped("ReverseOrientation Scale 1 -1 1"));
    CHECK_FALSE(flipped("Scale -1 -1 1"));
    CHECK_FALSE(flipped("ReverseOrientation ReverseOrientation"));
}

TEST_CASE("shading normals use the inverse transpose and flip with ReverseOrientation only", "[transform]") {
    const std::string mesh = "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"normal N\" [1 1 0 1 1 0 1 1 0]";
    CHECK(placed(scene_of("WorldBegin Scale 2 1 1 " + mesh).shapes[0]).normals[0] == Vec3{0.5f, 1, 0});
    CHECK(placed(scene_of("WorldBegin ReverseOrientation " + mesh).shapes[0]).normals[0] == Vec3{-1, -1, 0});
    CHECK(placed(scene_of("WorldBegin Scale 1 1 -1 " + mesh).shapes[0]).normals[0] == Vec3{1, 1, 0});
}

TEST_CASE("the inverse undoes the transform, and products agree with applying one after the other", "[transform]") {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> coordinate(-3, 3);
    for (int i = 0; i < 200; ++i) {
        const Transform a(random_matrix(random)), b(random_matrix(random));
        if (!a.invertible() || !b.invertible()) continue;
        const Vec3 p{coordinate(random), coordinate(random), coordinate(random)};
        const Transform identity = a * a.inverse();
        for (std::size_t r = 0; r < 4; ++r)
            for (std::size_t c = 0; c < 4; ++c)
                // Condition numbers of these matrices reach 1e4: 1e4 * 1e-16 with a margin.
                CHECK(identity.matrix()[r][c] == Approx(r == c ? 1 : 0).margin(1e-9));
        check_close((a * b).point(p), a.point(b.point(p)), 2e-4f);  // b's result is rounded to float, then stretched
        check_close((a * b).vector(p), a.vector(b.vector(p)), 2e-4f);
        // A normal stays perpendicular to its tangents.
        const Vec3 n{1, 2, -1}, tangent{1, 0, 1};
        CHECK(std::abs(dot(a.normal(n), a.vector(tangent))) <= 1e-5f * length(a.normal(n)) * length(a.vector(tangent)));
    }
}

TEST_CASE("a rotation keeps lengths and turns counter-clockwise about its axis", "[transform]") {
    check_close(Transform::rotate(30, 0, 0, 5).point({1, 0, 0}), {0.8660254f, 0.5f, 0});
    CHECK(Transform::rotate(90, 1, 0, 0).point({0, 1, 0}) == Vec3{0, 0, 1});
    CHECK(Transform::rotate(-270, 0, 1, 0).point({0, 0, 1}) == Vec3{1, 0, 0});
    CHECK(Transform::rotate(180, 0, 0, 1).point({1, 2, 3}) == Vec3{-1, -2, 3});
    CHECK(Transform::rotate(720, 1, 1, 1).is_identity());
    CHECK_FALSE(Transform::rotate(30, 0, 0, 0).invertible());
    CHECK_FALSE(Transform::scale(1, 0, 1).invertible());
    CHECK_FALSE((Transform() * Transform::scale(1, 0, 1)).invertible());
    CHECK_FALSE(Transform::scale(1, 0, 1).inverse().invertible());
}
