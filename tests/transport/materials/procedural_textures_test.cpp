// pbrt-v4's procedural textures against properties and values worked out by hand.
#include <catch2/catch.hpp>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "tests/transport/materials_scene.h"
#include "transport/math/noise.h"
#include "transport/textures/texture.h"

using namespace raylex;
using namespace raylex::transport;
using namespace raylex::test;

namespace {

Result<TextureTable> table_of(SceneTexture texture) {
    SceneDescription scene;
    scene.textures = {std::move(texture)};
    return TextureTable::build(scene);
}

TextureTable built(SceneTexture texture) {
    Result<TextureTable> table = table_of(std::move(texture));
    INFO((table ? std::string() : table.error().to_string()));
    REQUIRE(table.ok());
    return *std::move(table);
}

Real number_at(const TextureTable& table, const TexturePoint& at) {
    return table.real(*table.named_real("x", {}), at);
}

}  // namespace

TEST_CASE("gradient noise vanishes on the lattice, rises there by its gradient, and repeats after 256 cells",
          "[textures]") {
    for (int i = -3; i < 4; ++i)
        CHECK(gradient_noise({static_cast<Real>(i), static_cast<Real>(2 * i), static_cast<Real>(-i)}) == 0);
    // perm[perm[perm[0]]] = perm[perm[151]] = perm[17] = 36, and 36 % 16 = 4: the gradient (1, 0, 1) stands at the
    // origin. Its neighbours fade in by 10 t^3: at t = 1/64 they move the value by less than 2 x 10 x 64^-3.
    const Real t = Real(1) / 64, far = 20 * t * t * t;
    CHECK(std::abs(gradient_noise({t, 0, 0}) - t) <= far);
    CHECK(std::abs(gradient_noise({0, t, 0})) <= far);
    CHECK(std::abs(gradient_noise({0, 0, t}) - t) <= far);
    for (int i = 0; i < 32; ++i) {
        // Quarters and whole periods are exact in float.
        const Vec3 p{static_cast<Real>(i) * Real(0.25), Real(0.5), static_cast<Real>(i % 5) * Real(0.75)};
        CHECK(gradient_noise(p) == gradient_noise(p + Vec3{256, -512, 1024}));
        CHECK(std::abs(gradient_noise(p)) <= 1);
    }
    CHECK(gradient_noise({NAN, 0, 0}) == 0);
    CHECK(noise_differences({0, NAN, 0}, Real(0.01)).x == 0);
    for (int i = 0; i < 1000; ++i) {
        const Real x = static_cast<Real>(i) * Real(0.37),
                   step = i % 2 == 0 ? Real(0.01) : Real(0.75);  // into the next cell
        const Vec3 p{x - 100, x * Real(-1.7), x * Real(0.3)}, d = noise_differences(p, step);
        CHECK(d.x == gradient_noise({p.x + step, p.y, p.z}) - gradient_noise(p));
        CHECK(d.y == gradient_noise({p.x, p.y + step, p.z}) - gradient_noise(p));
        CHECK(d.z == gradient_noise({p.x, p.y, p.z + step}) - gradient_noise(p));
    }
}

TEST_CASE("fbm, wrinkled and windy are the sums of noise they are defined by", "[textures]") {
    SceneTexture fbm =
        real_texture("fbm", "x", {parameter(ParameterType::integer, "octaves", {2}), real("roughness", 0.25)});
    SceneTexture wrinkled = fbm;
    wrinkled.type = "wrinkled";
    fbm.to_world = Transform::translate(5, 0, 0);
    wrinkled.to_world = Transform::translate(5, 0, 0);
    const TextureTable sum = built(fbm), absolute = built(wrinkled), windy = built(real_texture("windy", "x", {}));
    bool signs_differ = false;
    for (int i = 0; i < 64; ++i) {
        const Real x = static_cast<Real>(i);
        const Vec3 p{x * Real(0.375), Real(0.625) + x * Real(0.125), Real(0.25)};
        const Real a = gradient_noise(p), b = gradient_noise(p * Real(1.99));
        TexturePoint at;
        at.position = p + Vec3{5, 0, 0};  // multiples of 1/8: exact
        CHECK(number_at(sum, at) == a + Real(0.25) * b);
        // pbrt-v4 adds the mean of the octave after the last.
        CHECK(number_at(absolute, at) == std::abs(a) + Real(0.25) * std::abs(b) + Real(0.2) * Real(0.0625));
        signs_differ = signs_differ || a * b < 0;
        at.position = p;
        CHECK(number_at(windy, at) ==
              std::abs(noise_sum(p * Real(0.1), {3, Real(0.5)})) * noise_sum(p, {6, Real(0.5)}));
    }
    CHECK(signs_differ);  // else the two sums were never told apart
}

TEST_CASE("directionmix goes by the normal along its direction, in the texture's space", "[textures]") {
    SceneTexture mix = real_texture(
        "directionmix", "x", {real("tex1", 3), real("tex2", 7), parameter(ParameterType::vector3, "dir", {2, 0, 0})});
    mix.to_world = Transform::rotate(90, 0, 0, 1);  // x becomes y
    const TextureTable table = built(mix);
    TexturePoint at;
    // Rotation by 90 degrees leaves a cosine below 1e-6: 4 of that at most.
    at.normal = {0, 1, 0};
    CHECK(number_at(table, at) == Approx(3).margin(4e-6));
    at.normal = {0, -1, 0};
    CHECK(number_at(table, at) == Approx(3).margin(4e-6));
    at.normal = {1, 0, 0};
    CHECK(number_at(table, at) == Approx(7).margin(4e-6));
    at.normal = {Real(0.8), Real(0.6), 0};
    CHECK(number_at(table, at) == Approx(0.6 * 3 + 0.4 * 7).margin(4e-6));
    const Result<TextureTable> nowhere =
        table_of(real_texture("directionmix", "x", {parameter(ParameterType::vector3, "dir", {0, 0, 0})}));
    REQUIRE_FALSE(nowhere.ok());
    CHECK(nowhere.error().line == 5);
    CHECK(nowhere.error().message.find("expected a direction") != std::string::npos);
}

TEST_CASE("bilerp blends its corners by the mapped texture coordinates", "[textures]") {
    const auto at = [](const TextureTable& table, Real u, Real v) {
        return number_at(table, {u, v, {}, {}, nullptr, {}});
    };
    const TextureTable table =
        built(real_texture("bilerp", "x", {real("v00", 2), real("v01", 3), real("v10", 5), real("v11", 9)}));
    // Corners and quarters are exact in float.
    CHECK(at(table, 0, 0) == 2);
    CHECK(at(table, 0, 1) == 3);
    CHECK(at(table, 1, 0) == 5);
    CHECK(at(table, 1, 1) == 9);
    CHECK(at(table, Real(0.25), Real(0.5)) == Real(0.75) * 2.5f + Real(0.25) * 7);
    CHECK(at(table, 2, 0) == 8);
    const TextureTable plain = built(real_texture("bilerp", "x", {real("vscale", 2), real("vdelta", 0.5)}));
    CHECK(at(plain, Real(0.75), Real(0.125)) == Real(0.75));  // pbrt's defaults: v
}

TEST_CASE("dots lie where noise puts one, inside their cells, and cover pi 0.35^2 of those cells", "[textures]") {
    // pbrt-v4 has its two values the other way round than their names.
    const TextureTable table = built(
        real_texture("dots", "x", {real("inside", 1), real("outside", 2), real("uscale", 16), real("vscale", 16)}));
    // A grid of 32^2 points for each of 16^2 whole cells, which stand around whole numbers.
    const int fine = 32, cells = 16;
    int dots = 0, covered = 0;
    for (int cy = 0; cy < cells; ++cy)
        for (int cx = 0; cx < cells; ++cx) {
            const Real s = static_cast<Real>(cx), t = static_cast<Real>(cy);
            const bool has_dot = gradient_noise({s + Real(0.5), t + Real(0.5), Real(0.5)}) > 0;
            int inside = 0;
            for (int i = 0; i < fine * fine; ++i) {
                const Real ds = (static_cast<Real>(i % fine) + Real(0.5)) / fine - Real(0.5),
                           dt = (static_cast<Real>(i / fine) + Real(0.5)) / fine - Real(0.5);
                inside += number_at(table, {(s + ds) / 16, (t + dt) / 16, {}, {}, nullptr, {}}) == 2;
            }
            CHECK((inside > 0) == has_dot);
            dots += has_dot;
            covered += inside;
        }
    REQUIRE(dots > 0);
    REQUIRE(dots < cells * cells);
    // Points that the edge misjudges lie within half a diagonal of a grid step of it: 2 pi 0.35 sqrt(2) / 32 at most.
    CHECK(static_cast<double>(covered) / (dots * fine * fine) == Approx(0.38484510).margin(2 * 3.1416 * 0.35 * 0.0442));
}

TEST_CASE("marble's veins follow y and its colours end at the spline's", "[textures]") {
    SceneDescription scene;
    scene.textures = {colour_texture("marble", "x", {real("variation", 0), real("scale", 2)})};
    Result<TextureTable> table = TextureTable::build(scene);
    REQUIRE(table.ok());
    ParameterSet set;
    set.parameters = {texture("reflectance", "x")};
    const Result<TextureId> id = table->rgb_parameter(set, "reflectance", Rgb(0), SpectrumRole::albedo, scene.color);
    REQUIRE(id.ok());
    const auto colour = [&](double phase) {
        TexturePoint at;
        at.position = {3, static_cast<Real>(phase / 2), -7};
        return table->rgb(*id, at);
    };
    const double half_pi = std::numbers::pi / 2;
    const Rgb bottom = colour(-half_pi), top = colour(half_pi), middle = colour(0);
    // The ends of the spline are its ends' control points times 1.5; the phase is float, at a maximum of the sine.
    CHECK(bottom.r == Approx(0.87).epsilon(1e-6));
    CHECK(bottom.b == Approx(0.9).epsilon(1e-6));
    CHECK(top.r == Approx(0.87).epsilon(1e-6));
    // t = 1/2 begins the fourth segment, at its first control point (0.5, 0.5, 0.5).
    CHECK(middle.r == Approx(0.75).epsilon(1e-6));
    CHECK(middle.b == Approx(0.75).epsilon(1e-6));
}

TEST_CASE("textures that pbrt has in one kind alone, and ptex, are refused with what was expected", "[textures]") {
    for (const char* type : {"fbm", "wrinkled", "windy"}) {
        const Result<TextureTable> table = table_of(colour_texture(type, "x", {}));
        REQUIRE_FALSE(table.ok());
        CHECK(table.error().line == 5);
        CHECK(table.error().message.find("expected a float texture") != std::string::npos);
    }
    const Result<TextureTable> marble = table_of(real_texture("marble", "x", {}));
    REQUIRE_FALSE(marble.ok());
    CHECK(marble.error().message.find("expected a spectrum texture") != std::string::npos);
    const Result<TextureTable> ptex = table_of(colour_texture("ptex", "x", {string("filename", "a.ptx")}));
    REQUIRE_FALSE(ptex.ok());
    CHECK(ptex.error().line == 5);
    CHECK(ptex.error().message.find("type imagemap") != std::string::npos);
}
