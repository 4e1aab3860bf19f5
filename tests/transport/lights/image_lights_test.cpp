// Lights with images: goniometric, projection, stretched spots, textured area lights; "power" and "illuminance".
#include <catch2/catch.hpp>

#include <cmath>
#include <numbers>

#include "tests/transport/image_file.h"
#include "tests/transport/lights/light_draws.h"
#include "tests/transport/lit_scene.h"
#include "transport/replicates.h"

using namespace raylex;
using namespace raylex::transport;

namespace image_lights {

TEST_CASE("a goniometric light emits its image into pbrt's directions", "[lights]") {
    // The image's axis is y of the light's space: the octahedral layout with z and y swapped.
    constexpr int n = 8;
    std::vector<Rgb> pixels;
    for (int i = 0; i < n * n; ++i) pixels.emplace_back(static_cast<Real>(1 + i % 5), 0, static_cast<Real>(i % 3));
    const ImageFile file(n, n, pixels);
    const Lit scene = lit("Translate 1 2 3\nLightSource \"goniometric\" \"rgb I\" [2 2 2] \"float scale\" 0.5" +
                          file.parameter() + sphere_in_the_middle);
    for (int i = 0; i < n * n; ++i) {
        const Vec3 w =
            direction_from_octahedral({(static_cast<Real>(i % n) + 0.5f) / n, (static_cast<Real>(i / n) + 0.5f) / n});
        const Vec3 direction{w.x, w.z, w.y};
        LightSample s;
        REQUIRE(draw(scene, Vec3{1, 2, 3} + direction * 2, 0, s));
        const Rgb& p = pixels[static_cast<std::size_t>(i)];
        // Colours are averaged; 4 is the squared distance. A few float operations.
        CHECK(static_cast<double>(s.radiance.g) == Approx(double{p.r + p.g + p.b} / 3 / 4).epsilon(1e-5));
        CHECK(s.delta);
    }
}

TEST_CASE("goniometric and projection lights emit their power, and draw directions with their density", "[lights]") {
    constexpr int w = 12, h = 12;
    std::vector<Rgb> pixels;
    for (int i = 0; i < w * h; ++i) pixels.emplace_back(i % 7 == 0 ? 5.f : i % 5 == 0 ? 0.f : 0.5f);
    const ImageFile square(w, h, pixels);
    pixels.resize(w * 6);
    const ImageFile wide(w, 6, pixels);
    const std::string turned = "Translate 0.3 0 0\nRotate 40 1 1 0\n";
    struct Case {
        std::string text;
        double power;
    };
    for (const Case& each :
         {Case{turned + "LightSource \"goniometric\" \"float power\" 30 \"rgb I\" [1 1 1]" + square.parameter(), 30},
          Case{turned + "LightSource \"projection\" \"float power\" 30 \"float fov\" 60" + wide.parameter(), 30},
          Case{turned + "LightSource \"projection\" \"float power\" 30 \"float scale\" 2 \"float fov\" 120" +
                   wide.parameter(),
               60},
          // Stretched: the image's directions are compressed; each keeps its intensity in the light's space.
          Case{"Scale 1 2 0.7\nLightSource \"goniometric\" \"rgb I\" [1 1 1]" + square.parameter(), 0}}) {
        INFO(each.text);
        const Lit scene = lit(each.text + sphere_in_the_middle);
        if (each.power > 0) {
            // Directions are drawn by pixel, so only the solid angle within pixels varies: 2^14 points.
            const Mean power = mean_of(1 << 14, [&](std::uint64_t i) {
                EmissionSample s;
                return emit(scene, i, s) ? static_cast<double>(s.power.g) : 0.0;
            });
            CHECK(std::abs(power.value - each.power) < 4 * power.error + 0.004 * each.power);  // midpoints of pixels
        }
        for (std::uint64_t i = 0; i < 500; ++i) {
            EmissionSample s;
            if (!emit(scene, i, s)) continue;
            const EmissionDensity density = scene.lights.emission_density(
                scene.lights.chooser(LightChoice::light_sampling), scene.geometry, s.from, s.direction);
            REQUIRE(density.position == 1);
            // Power times density is the intensity of a light sample in that direction.
            LightSample seen;
            REQUIRE(draw(scene, s.origin + s.direction, i, seen));
            const double both = static_cast<double>(s.power.g) * static_cast<double>(density.direction);
            const double there = static_cast<double>(seen.radiance.g);
            if (std::abs(both - there) > 1e-3 * both) {
                // Within rounding of a pixel's edge, either of two pixels may be read.
                REQUIRE((std::abs(both / there - 10) < 0.1 || std::abs(there / both - 10) < 0.1));
            }
        }
        check_directions(
            [&](std::uint64_t i, Vec3& d) {
                EmissionSample s;
                if (!emit(scene, i, s)) return false;
                d = s.direction;
                return true;
            },
            [&](const Vec3& d) { return density_of_direction(scene, d); });
    }
}

TEST_CASE("a projection light projects its image upright and ends at its border", "[lights]") {
    // 4 x 2 pixels, 90 degrees over the shorter side: half sizes of 2 and 1 at distance 1.
    std::vector<Rgb> pixels;
    for (int i = 0; i < 8; ++i) pixels.emplace_back(static_cast<Real>(1 + i));
    const ImageFile file(4, 2, pixels);
    const Lit scene = lit("LightSource \"projection\"" + file.parameter() + sphere_in_the_middle);
    for (int y = 0; y < 2; ++y)
        for (int x = 0; x < 4; ++x) {
            const Vec3 at{-1.5f + static_cast<Real>(x), 0.5f - static_cast<Real>(y), 1};  // left is -x, up is +y
            LightSample s;
            REQUIRE(draw(scene, at, 0, s));
            CHECK(static_cast<double>(s.radiance.g * length_squared(at)) == Approx(1 + 4 * y + x).epsilon(1e-5));
        }
    LightSample s;
    for (const Vec3& outside : {Vec3{2.01f, 0, 1}, Vec3{0, 1.01f, 1}, Vec3{0, 0, -1}, Vec3{0, -1.01f, 1}})
        CHECK_FALSE(draw(scene, outside, 0, s));
}

TEST_CASE("a stretched spot has its cone in its own space, as in pbrt, and draws directions by density", "[lights]") {
    const std::string stretched =
        "Rotate 20 0 1 0\nScale 1.3 0.7 1.1\nLightSource \"spot\" \"rgb I\" [20 20 20] \"point3 from\" [1 0 3] "
        "\"point3 to\" [0 0 0] \"float coneangle\" 35 \"float conedeltaangle\" 10\n";
    const Lit scene = lit(stretched + sphere_in_the_middle);
    const double c = std::cos(20 * pi_d / 180), s = std::sin(20 * pi_d / 180), scale[3] = {1.3, 0.7, 1.1};
    const double from[3] = {c * 1.3 + s * 3.3, 0, -s * 1.3 + c * 3.3};
    const double axis[3] = {-1 / std::sqrt(10), 0, -3 / std::sqrt(10)};
    int lit_points = 0;
    for (int i = 0; i < 400; ++i) {
        const Vec3 p{static_cast<Real>(i % 20) * 0.3f - 2.4f, static_cast<Real>(i / 20) * 0.2f - 2.1f, -1};
        // pbrt-v4's SpotLight::SampleLi by hand: the direction in the light's space, and its angle to the axis there.
        const double w[3] = {static_cast<double>(p.x) - from[0], static_cast<double>(p.y), -1 - from[2]};
        const double local[3] = {(c * w[0] - s * w[2]) / scale[0], w[1] / scale[1], (s * w[0] + c * w[2]) / scale[2]};
        const double cosine = (local[0] * axis[0] + local[1] * axis[1] + local[2] * axis[2]) /
                              std::sqrt(local[0] * local[0] + local[1] * local[1] + local[2] * local[2]);
        const double zero = std::cos(35 * pi_d / 180), full = std::cos(25 * pi_d / 180);
        const double t = std::clamp((cosine - zero) / (full - zero), 0.0, 1.0);
        const double expected = 20 * t * t * (3 - 2 * t) / (w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
        LightSample found;
        const double radiance = draw(scene, p, 0, found) ? static_cast<double>(found.radiance.g) : 0;
        // A dozen float roundings of the direction, times the falloff's steepest slope: 1.5 / (full - zero).
        CHECK(std::abs(radiance - expected) <= 1.5 * 20 / 8 * 16 * 0x1p-24 / (full - zero) + 4 * 0x1p-24 * expected);
        lit_points += expected > 0;
    }
    CHECK((lit_points > 40 && lit_points < 360));
    for (std::uint64_t i = 0; i < 500; ++i) {
        EmissionSample e;
        LightSample seen;
        if (!emit(scene, i, e) || !draw(scene, e.origin + e.direction, i, seen)) continue;
        // Power times density is the intensity of a light sample there; the cone's edge is steep (see above).
        CHECK(static_cast<double>(e.power.g) * density_of_direction(scene, e.direction) ==
              Approx(static_cast<double>(seen.radiance.g)).epsilon(1e-4).margin(1e-3));
    }
    check_directions(
        [&](std::uint64_t i, Vec3& d) {
            EmissionSample e;
            if (!emit(scene, i, e)) return false;
            d = e.direction;
            return true;
        },
        [&](const Vec3& d) { return density_of_direction(scene, d); });
    // A cone that is mirrored and scaled uniformly stays round and needs no extra data.
    CHECK(lit("Scale -2 2 2\nLightSource \"spot\"" + sphere_in_the_middle).lights.lights()[0].image < 0);
}

TEST_CASE("'illuminance' scales an image light as pbrt does", "[lights]") {
    constexpr int n = 64;
    std::vector<Rgb> pixels;
    for (int i = 0; i < n * n; ++i) pixels.emplace_back(static_cast<Real>(1 + i % 4));
    const ImageFile file(n, n, pixels);
    const Lit scene =
        lit("LightSource \"infinite\" \"float illuminance\" 100" + file.parameter() + sphere_in_the_middle);
    // pbrt uses 2 pi of the 4 pi that the pixels cover: the surface gets twice the requested value.
    const Mean found = irradiance(scene, {0, 0, 0}, {0, 0, 1}, 1 << 15);
    CHECK(std::abs(found.value - 200) < 4 * found.error);
}

TEST_CASE("an image on an area light: pbrt's orientation, means, densities, power", "[lights]") {
    // The top of the left half is dark: values 1 2 / 3 8, from the top left.
    const ImageFile file(2, 2, {Rgb(1), Rgb(2), Rgb(3), Rgb(8)});
    const std::string light = "AreaLightSource \"diffuse\"" + file.parameter();
    const std::string quad =
        "\nShape \"trianglemesh\" \"integer indices\" [0 2 1 0 3 2] \"point3 P\" [-1 -1 2 1 -1 2 1 1 2 -1 1 2]"
        " \"point2 uv\" [0 0 1 0 1 1 0 1]";
    const auto shown = [](double u, double v) {  // bilinear between texel centres, clamped at the border
        const double x = std::min(std::max(2 * u - 0.5, 0.0), 1.0), y = std::min(std::max(2 * (1 - v) - 0.5, 0.0), 1.0);
        return (1 * (1 - x) + 2 * x) * (1 - y) + (3 * (1 - x) + 8 * x) * y;
    };
    struct Case {
        std::string shape;
        bool flat;
    };
    for (const Case& each : {Case{quad, true},
                             Case{"\nShape \"bilinearmesh\" \"point3 P\" [-1 -1 2 -1 1 2 1 -1 2 1 1 2]"
                                  " \"point2 uv\" [0 0 0 1 1 0 1 1]",
                                  true},
                             Case{"\nTranslate 0.2 0 3 Shape \"sphere\" \"float radius\" 0.8", false},
                             Case{"\nTranslate 0 0 3 Rotate 180 1 0 0 Shape \"disk\"", false},
                             Case{"\nTranslate 3 0 0 Shape \"cylinder\"", false}}) {
        INFO(each.shape);
        const Lit scene = lit(light + " \"float scale\" 2 \"bool twosided\" true" + each.shape);
        const Vec3 n = each.shape.find("cylinder") == std::string::npos ? Vec3{0, 0, 1} : Vec3{1, 0, 0};
        const LightChooser& chooser = scene.lights.chooser(LightChoice::mis);
        // Light samples and traced directions give the same mean and the same densities.
        const Mean sampled = irradiance(scene, {}, n);
        const Mean traced = mean_of(1 << 15, [&](std::uint64_t i) {
            Ray ray;
            const Vec3 local = sample_cosine_hemisphere(numbers(i).get_2d(2));
            ray.direction = normalize(Frame::from_normal(n).to_world(local));
            Hit hit;
            scene.geometry.intersect({&ray, 1}, {&hit, 1});
            if (!hit.valid()) return 0.0;
            SurfacePoint point;
            SurfaceSource source;
            scene.geometry.surfaces({&ray, 1}, {&hit, 1}, {&point, 1}, {&source, 1});
            const std::uint32_t index = scene.geometry.shapes()[hit.shape].first_light + hit.primitive;
            return pi_d * static_cast<double>(scene.lights.emitted(index, point, point.wo).g);
        });
        CAPTURE(sampled.value, sampled.error, traced.value, traced.error);
        // A sphere is two-sided and sampled by area: the near side hides samples of its far side.
        if (each.shape.find("sphere") == std::string::npos && each.shape.find("cylinder") == std::string::npos)
            CHECK(std::abs(sampled.value - traced.value) < 4 * std::hypot(sampled.error, traced.error));
        int at_borders = 0;
        for (std::uint64_t i = 0; i < 300; ++i) {
            LightSample s;
            if (!draw(scene, {}, i, s)) continue;
            const double again = static_cast<double>(scene.lights.density(chooser, scene.geometry, Vec3(), s));
            at_borders += std::abs(again / static_cast<double>(s.pdf) - 1) > 1e-3 ? 1 : 0;
            if (!each.flat) continue;
            const double u = (static_cast<double>(s.target.x) + 1) / 2, v = (static_cast<double>(s.target.y) + 1) / 2;
            CHECK(static_cast<double>(s.radiance.g) == Approx(2 * shown(u, v)).epsilon(1e-4));
        }
        // At the boundary of a grid cell, rounding may select the neighbour's density. The grid is 2 x 2 here, and less
        // than one sample in 10,000 is within 1e-5 of its lines.
        CHECK(at_borders <= 1);
    }
    // Two triangles of power 10 each, on both sides; a sphere of 10.
    for (const auto& [shape, power, warnings] :
         {std::tuple{quad, 20.0, std::size_t{1}}, {std::string("\nShape \"sphere\" \"float radius\" 2"), 10.0, 0}}) {
        const Lit scene =
            lit("AreaLightSource \"diffuse\" \"rgb L\" [3 3 3] \"float power\" 10 \"bool twosided\" true" + shape);
        const Mean found = mean_of(1 << 12, [&, &scene = scene](std::uint64_t i) {
            const PixelSampler sampler = numbers(i);
            EmissionSample s;
            if (!scene.lights.sample_emission(scene.lights.chooser(LightChoice::light_sampling), scene.geometry,
                                              sampler.get_1d(1), sampler.get_2d(2), sampler.get_2d(3), s))
                return 0.0;
            return static_cast<double>(s.power.g);
        });
        CHECK(found.value == Approx(3 * power).epsilon(1e-4));  // L's 3 is a further factor, as in pbrt
        CHECK(scene.warnings.size() == warnings);
    }
}

TEST_CASE("errors of lights with images name the cause", "[lights]") {
    const ImageFile wide(4, 2, std::vector<Rgb>(8, Rgb(1))), black(2, 2, std::vector<Rgb>(4, Rgb(0)));
    struct Case {
        std::string text, message;
    };
    for (const Case& each :
         {Case{"LightSource \"goniometric\"", "without 'filename'"}, Case{"LightSource \"projection\"", "without"},
          Case{"LightSource \"goniometric\"" + wide.parameter(), "must be square"},
          Case{"LightSource \"infinite\"" + wide.parameter(), "must be square"},
          Case{"LightSource \"projection\" \"float fov\" 180" + wide.parameter(), "between 0 and 180"},
          Case{"LightSource \"projection\" \"float power\" 5" + black.parameter(), "its image is black"},
          Case{"LightSource \"infinite\" \"float illuminance\" 5" + black.parameter(), "its image is black"},
          Case{"LightSource \"point\" \"float scale\" -1", "expected 0 or more"},
          Case{"AreaLightSource \"diffuse\" \"float scale\" -1\nShape \"sphere\"", "expected 0 or more"},
          Case{"LightSource \"infinite\" \"point3 portal\" [0 0 0 1 0 0 1 1 0]", "four point3"},
          Case{"LightSource \"infinite\" \"point3 portal\" [0 0 0 1 0 0 1 1 1 0 1 0]", "not a rectangle"},
          Case{"LightSource \"infinite\" \"point3 portal\" [0 0 0 1 0 0 2 1 0 0 1 0]", "right angles"},
          Case{"LightSource \"infinite\" \"point3 portal\" [0 0 0 0 0 0 1 1 0 0 1 0]", "the same point"},
          Case{"AreaLightSource \"diffuse\" \"rgb L\" [1 1 1]" + wide.parameter() + "\nShape \"sphere\"",
               "exclude each other"}}) {
        INFO(each.text);
        const auto made = try_lit(each.text);
        REQUIRE_FALSE(made.ok());
        CHECK(made.error().to_string().find(each.message) != std::string::npos);
        CHECK(made.error().file == "test.pbrt");
        CHECK(made.error().line == 2);
    }
}

TEST_CASE("integrators that trace paths from lights find the path tracer's image under lights with images",
          "[bdpt][lighttracer][render][statistical][gate]") {
    const std::string integrator = GENERATE("bdpt", "lighttracer");
    std::vector<Rgb> pixels;
    for (int i = 0; i < 64; ++i) pixels.emplace_back(i % 3 == 0 ? 1.5f : 0.2f);
    const ImageFile file(8, 8, pixels);
    // A room with a hole in its ceiling: the sky enters by the portal there; the screen at the back is an area light.
    const std::string scene = render_test::plain_film + R"(
PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
LookAt 0 1 4.5  0 0.8 0  0 1 0
Camera "perspective" "float fov" 45
WorldBegin
AttributeBegin LightSource "infinite" "float scale" 3 "point3 portal" [-1 2 -1  1 2 -1  1 2 1  -1 2 1] )" +
                              file.parameter() + R"( AttributeEnd
AttributeBegin Translate -1.2 1.5 0.5 LightSource "goniometric" "rgb I" [2 2 2] )" +
                              file.parameter() + R"( AttributeEnd
AttributeBegin Translate 1.2 1.2 1 Rotate 90 1 0 0 LightSource "projection" "float scale" 3 "float fov" 70 )" +
                              file.parameter() + R"( AttributeEnd
Material "diffuse" "rgb reflectance" [0.6 0.6 0.6]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-2 0 2 2 0 2 2 0 -2 -2 0 -2]
AttributeBegin AreaLightSource "diffuse" "bool twosided" true )" +
                              file.parameter() + R"(
Shape "bilinearmesh" "point3 P" [-1 0.3 -1.5 1 0.3 -1.5 -1 1.6 -1.5 1 1.6 -1.5] AttributeEnd
AttributeBegin Translate 0 0.5 0 Shape "sphere" "float radius" 0.4 AttributeEnd
)";
    transport::RenderSettings settings;
    settings.paths.max_depth = 3;
    settings.samples.per_pixel = 128;
    render_test::compare_with_path(scene, settings, render_test::integrator_named(integrator), 10, 128,
                                   {"C<RD>B", "C<RD>L", "C<RD><RD>+B", "C<RD><RD>+L", "CL", "C.*[LB]"});
}

}  // namespace image_lights
