#include <catch2/catch.hpp>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numbers>
#include <random>

#include "tests/transport/lit_scene.h"
#include "transport/math/sampling.h"
#include "transport/samplers/pixel_sampler.h"

using namespace raylex;
using namespace raylex::transport;

namespace {

/// Irradiance at `p` on a plane with normal `n`, by light samples only, unoccluded.
double irradiance(const Lit& scene, const Vec3& p, const Vec3& n, int samples) {
    double sum = 0;
    for (int i = 0; i < samples; ++i) {
        const PixelSampler sampler(SamplerKind::sobol, 0, 0, 0, static_cast<std::uint64_t>(i));
        LightSample s;
        if (!scene.lights.sample(scene.lights.chooser(LightChoice::light_sampling), scene.geometry, p,
                                 sampler.get_1d(1), sampler.get_2d(2), s))
            continue;
        const float cosine = dot(n, s.wi);
        if (cosine > 0) sum += static_cast<double>(luminance(s.radiance) * cosine / s.pdf);
    }
    return sum / samples;
}

}  // namespace

TEST_CASE("the irradiance of a point light is I cos / d^2", "[lights]") {
    // Row J. Not random: only the roundings of a handful of float operations.
    const Lit scene = lit(R"(LightSource "point" "rgb I" [3 3 3] "point3 from" [1 2 0.5])");
    const double d2 = 1 + 4 + 0.25, expected = 3 * (2 / std::sqrt(d2)) / d2;
    CHECK(irradiance(scene, {0, 0, 0}, {0, 1, 0}, 4) == Approx(expected).epsilon(1e-6));
}

TEST_CASE("the irradiance of a disk light is pi L r^2 / (r^2 + h^2) below its centre", "[lights]") {
    // Row L, also with a transform that stretches the disk to twice its size. 2^14 scrambled points: error below 1e-4.
    for (const double scale : {1.0, 2.0}) {
        const std::string s = std::to_string(scale);
        const Lit scene =
            lit("AttributeBegin\nTranslate 0 0 3\nScale " + s + " " + s + " " + s +
                "\nRotate 180 1 0 0\n"
                "AreaLightSource \"diffuse\" \"rgb L\" [5 5 5]\nShape \"disk\" \"float radius\" 1\nAttributeEnd");
        const double r2 = scale * scale;
        CHECK(irradiance(scene, {0, 0, 0}, {0, 0, 1}, 1 << 14) ==
              Approx(5 * std::numbers::pi * r2 / (r2 + 9)).epsilon(1e-4));
    }
}

TEST_CASE("a rectangle light matches Lambert's polygon formula, with 2 or 200 triangles or a patch", "[lights]") {
    // Row M: E = L/2 sum of edge angles times the cosines of their planes.
    const Vec3 corner[4] = {{-1, -1, 2}, {-1, 1, 2}, {1, 1, 2}, {1, -1, 2}};
    double expected = 0;
    for (int i = 0; i < 4; ++i) {
        const DVec3 a = normalize(DVec3(corner[i])), b = normalize(DVec3(corner[(i + 1) % 4]));
        expected += std::acos(dot(a, b)) * normalize(cross(a, b)).z;
    }
    expected = std::abs(expected) / 2;
    const std::string begin = "AreaLightSource \"diffuse\" \"rgb L\" [1 1 1]\n";
    std::string positions = "\"point3 P\" [", indices = "\"integer indices\" [";
    for (int j = 0; j <= 10; ++j)
        for (int i = 0; i <= 10; ++i)
            positions += std::to_string(-1 + 0.2 * i) + " " + std::to_string(-1 + 0.2 * j) + " 2 ";
    for (int j = 0; j < 10; ++j)
        for (int i = 0; i < 10; ++i) {
            const int a = 11 * j + i;
            for (const int k : {a, a + 12, a + 1, a, a + 11, a + 12}) indices += std::to_string(k) + " ";
        }
    // 2^14 scrambled points; 200 triangles share them, so each has fewer: 1e-3 covers both.
    for (const std::string& shape :
         {std::string(
              R"(Shape "trianglemesh" "integer indices" [0 2 1 0 3 2] "point3 P" [-1 -1 2 1 -1 2 1 1 2 -1 1 2])"),
          std::string(R"(Shape "bilinearmesh" "point3 P" [1 -1 2 -1 -1 2 1 1 2 -1 1 2])"),
          "Shape \"trianglemesh\" " + indices + "] " + positions + "]"})
        CHECK(irradiance(lit(begin + shape), {0, 0, 0}, {0, 0, 1}, 1 << 14) == Approx(expected).epsilon(1e-3));
}

TEST_CASE("the octahedral map has an inverse and keeps areas", "[lights]") {
    double sum = 0;
    for (std::uint64_t i = 0; i < 20000; ++i) {
        const PixelSampler sampler(SamplerKind::sobol, 2, 0, 0, i);
        const Vec2 uv = sampler.get_2d(0);
        const Vec3 d = direction_from_octahedral(uv);
        REQUIRE(length(d) == Approx(1).epsilon(1e-5));
        const Vec2 back = octahedral_from_direction(d);
        // The square root at the folds increases 1e-7 to at most 4e-4.
        REQUIRE(std::abs(back.x - uv.x) < 5e-4f);
        REQUIRE(std::abs(back.y - uv.y) < 5e-4f);
        sum += d.z > 0.5f;
    }
    CHECK(sum / 20000 == Approx(0.25).margin(1e-3));  // a cap's area is proportional to its height
}

TEST_CASE("an image environment is sampled by its luminance, with the density pdf()", "[lights]") {
    constexpr int n = 8;
    std::vector<Rgb> pixels(n * n, Rgb(0.1f));
    pixels[19] = Rgb(50);
    pixels[40] = Rgb(0);
    const EnvironmentImage image(n, pixels, Placement(Transform::rotate(40, 1, 1, 0)));
    double integral = 0, flux = 0, uniform_flux = 0;
    constexpr int count = 1 << 14;
    for (std::uint64_t i = 0; i < count; ++i) {
        const PixelSampler sampler(SamplerKind::sobol, 3, 0, 0, i);
        integral +=
            static_cast<double>(image.pdf(sample_uniform_sphere(sampler.get_2d(0)))) * 4 * std::numbers::pi / count;
        Vec3 d;
        Rgb radiance;
        float pdf = 0;
        REQUIRE(image.sample(sampler.get_2d(1), d, radiance, pdf));
        REQUIRE(pdf > 0);
        flux += static_cast<double>(radiance.g / pdf) / count;
        uniform_flux += static_cast<double>(image.radiance(sample_uniform_sphere(sampler.get_2d(0))).g) * 4 *
                        std::numbers::pi / count;
    }
    CHECK(integral == Approx(1).epsilon(0.01));  // stratified over 64 cells of a step function
    CHECK(flux == Approx(uniform_flux).epsilon(0.01));
    CHECK(flux ==
          // radiance / pdf is constant except for black pixels
          Approx((62 * 0.1 + 50) / 64 * 4 * std::numbers::pi).epsilon(1e-4));
}

TEST_CASE("with scattering an image environment is sampled by its excess over the mean, with the density pdf()",
          "[lights]") {
    // The density is max(L - mean, 0) + L / 10 with mean (61 x 1 + 50 + 8) / 64: in closed form for each pixel.
    constexpr int n = 8, count = 1 << 16;
    std::vector<Rgb> pixels(n * n, Rgb(1));
    pixels[19] = Rgb(50);
    pixels[40] = Rgb(0);
    pixels[41] = Rgb(8);
    const auto by = EnvironmentImage::By::excess;
    const EnvironmentImage image(n, pixels, Placement(Transform()));
    const double mean = 119.0 / 64, total = (50 - mean) + (8 - mean) + 11.9;
    std::vector<int> drawn(n * n, 0);
    for (std::uint64_t i = 0; i < count; ++i) {
        const PixelSampler sampler(SamplerKind::independent, 3, 0, 0, i);
        Vec3 d;
        Rgb radiance;
        float pdf = 0;
        REQUIRE(image.sample(sampler.get_2d(1), d, radiance, pdf, by));
        const Vec2 uv = octahedral_from_direction(d);
        const auto pixel = static_cast<std::size_t>(uv.y * n) * n + static_cast<std::size_t>(uv.x * n);
        ++drawn[std::min(pixel, drawn.size() - 1)];
    }
    double chi_squared = 0;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        const double value = double{pixels[i].g}, share = (std::max(value - mean, 0.0) + value / 10) / total;
        const Vec3 center =
            direction_from_octahedral({(static_cast<float>(i % n) + 0.5f) / n, (static_cast<float>(i / n) + 0.5f) / n});
        // Shares are differences of cumulative floats, each rounded by at most 2^-25 and at least 8e-4.
        CHECK(static_cast<double>(image.pdf(center, by)) ==
              Approx(share * n * n / (4 * std::numbers::pi)).epsilon(1e-3).margin(1e-9));
        CHECK((image.pdf(center, by) > 0) == (value > 0));  // no pixel that emits is left to scattering alone
        if (value > 0) chi_squared += std::pow(drawn[i] - share * count, 2) / (share * count);
        else CHECK(drawn[i] == 0);
    }
    // 62 degrees of freedom: 62 + 5 sqrt(124). Rounding at the borders of pixels affects 1e-6 of the samples.
    CHECK(chi_squared < 118);

    // A constant sky has no excess: the same as without compensation.
    const EnvironmentImage even(n, std::vector<Rgb>(n * n, Rgb(1)), Placement(Transform()));
    CHECK(even.pdf({0, 0, 1}, by) == Approx(double{even.pdf({0, 0, 1})}).epsilon(1e-5));
}

TEST_CASE("only path's weighted light samples use the excess of skies", "[lights]") {
    const Lit scene = lit(R"(LightSource "point" "rgb I" [1 1 1])");
    const auto lights = scene.lights.lights();
    CHECK(LightChooser::by_receiver(lights, scene.geometry, LightChoice::mis).compensates());
    CHECK_FALSE(LightChooser::by_receiver(lights, scene.geometry, LightChoice::light_sampling).compensates());
    for (std::size_t i = 0; i < light_choices; ++i)  // bdpt, light paths
        CHECK_FALSE(scene.lights.chooser(static_cast<LightChoice>(i)).compensates());
}

TEST_CASE("weak lights are chosen with a minimum probability and black ones never", "[lights]") {
    const Lit scene = lit(R"(
LightSource "point" "rgb I" [1e6 1e6 1e6]
LightSource "point" "rgb I" [1e-6 1e-6 1e-6] "point3 from" [1 0 0]
LightSource "point" "rgb I" [0 0 0] "point3 from" [0 1 0]
)");
    for (const LightChoice choice : {LightChoice::mis, LightChoice::mis_uniform, LightChoice::light_sampling_uniform}) {
        int chosen[3] = {};
        for (std::uint64_t i = 0; i < 1000; ++i) {
            LightSample s;
            REQUIRE(scene.lights.sample(scene.lights.chooser(choice), scene.geometry, Vec3{5, 5, 5}, 0,
                                        {static_cast<float>(i) / 1000, 0.5f},
                                        s));  // few lights: u.x chooses
            ++chosen[s.light];
        }
        // Half of the tenth that ignores power, or half of all; an interval's share of 1000 evenly spaced points is off
        // by at most one.
        CHECK(std::abs(chosen[1] - (choice == LightChoice::mis ? 50 : 500)) <= 1);
        CHECK(chosen[2] == 0);
    }
}

namespace {

struct Emitter {
    std::string text;  ///< one light beside a point light of another group, so that choices matter
    Rgb emission;      ///< radiance; intensity of a point light
    double area;       ///< of its surface; 0: none
    bool two_sided = false;
};

}  // namespace

TEST_CASE("a light subpath begins with the emission over the density that bidirectional weights use", "[lights]") {
    const std::string area = "AreaLightSource \"diffuse\" \"rgb L\" [2 3 5]\n";
    const std::vector<Emitter> emitters{
        {area + "Shape \"trianglemesh\" \"point3 P\" [0 0 0  3 0 0  0 4 0]", {2, 3, 5}, 6},
        {"AreaLightSource \"diffuse\" \"rgb L\" [2 3 5] \"bool twosided\" true\n"
         "Shape \"trianglemesh\" \"point3 P\" [0 0 0  3 0 0  0 4 0]",
         {2, 3, 5},
         6,
         true},
        // A trapezium with parallel sides 4 and 1 and height 2: its patch is denser at the short side.
        {area + "Shape \"bilinearmesh\" \"point3 P\" [0 0 0  4 0 0  0 2 0  1 2 0]", {2, 3, 5}, 5},
        {area + "Scale 2 1 1 Shape \"disk\" \"float radius\" 3 \"float innerradius\" 1",
         {2, 3, 5},
         2 * std::numbers::pi * 8},
        {area + "Shape \"sphere\" \"float radius\" 2", {2, 3, 5}, 16 * std::numbers::pi},
        {area + "Shape \"cylinder\" \"float radius\" 2 \"float zmin\" 0 \"float zmax\" 3",
         {2, 3, 5},
         12 * std::numbers::pi},
        {"LightSource \"point\" \"rgb I\" [2 3 5]", {2, 3, 5}, 0},
        {"LightSource \"spot\" \"rgb I\" [2 3 5] \"float coneangle\" 40 \"float conedeltaangle\" 15", {2, 3, 5}, 0},
        {"LightSource \"distant\" \"rgb L\" [2 3 5]", {2, 3, 5}, 0},
        {"LightSource \"infinite\" \"rgb L\" [2 3 5]", {2, 3, 5}, 0}};
    for (const Emitter& emitter : emitters) {
        INFO(emitter.text);
        const Lit scene = lit("AttributeBegin\n" + emitter.text +
                              "\nAttributeEnd\nLightSource \"point\" \"rgb I\" [7 7 7] \"point3 from\" [9 9 9]\n"
                              "Shape \"sphere\" \"float radius\" 0.5");
        const auto lights = scene.lights.lights();
        REQUIRE(lights.size() >= 2);
        double inverse = 0, inverse_squared = 0;
        int count = 0;
        for (std::uint64_t i = 0; i < 4000; ++i) {
            const PixelSampler sampler(SamplerKind::independent, 3, 0, 0, i);
            EmissionSample s;
            if (!scene.lights.sample_emission(scene.lights.chooser(LightChoice::light_sampling), scene.geometry,
                                              sampler.get_1d(1), sampler.get_2d(2), sampler.get_2d(3), s))
                continue;
            const Light& light = scene.lights.lights()[s.from.light];
            if (light.kind == LightKind::point && light.emission.r == 7) continue;
            const EmissionDensity density = scene.lights.emission_density(
                scene.lights.chooser(LightChoice::light_sampling), scene.geometry, s.from, s.direction);
            double radiated = 1;
            if (light.is_area()) radiated = std::abs(static_cast<double>(dot(s.from.target_normal, s.direction)));
            else if (light.kind == LightKind::spot)
                radiated = static_cast<double>(
                    spot_falloff(light.direction, light.versine_full, light.versine_zero, s.direction));
            for (int c = 0; c < 3; ++c) {
                // About thirty float operations in either direction, with directions that rounding turns by 2^-23. Near
                // the horizon and the cone's edge that is a large relative error.
                const double both = static_cast<double>(s.power[c]) * static_cast<double>(density.position) *
                                    static_cast<double>(density.direction);
                const double expected = static_cast<double>(emitter.emission[c]) * radiated;
                REQUIRE(std::abs(both - expected) <= 5 * (64 * 0x1p-24 * radiated + 16 * 0x1p-23));
            }
            if (light.is_area() && !emitter.two_sided) REQUIRE(dot(s.from.target_normal, s.direction) > 0);
            ++count;
            LightSample other;  // its position's density is the probability of the choice
            while (lights[other.light].kind != LightKind::point) ++other.light;
            const double chosen =
                1 - static_cast<double>(scene.lights
                                            .emission_density(scene.lights.chooser(LightChoice::light_sampling),
                                                              scene.geometry, other, s.direction)
                                            .position);
            const double inverse_density = chosen / static_cast<double>(density.position);
            inverse += inverse_density;
            inverse_squared += inverse_density * inverse_density;
        }
        REQUIRE(count > 200);
        if (emitter.area == 0) continue;
        // The mean of 1 / density over points drawn with it is the area. 4 standard errors for ten tests, and rounding.
        const double mean = inverse / count;
        const double error = std::sqrt(std::max(0.0, inverse_squared / count - mean * mean) / count);
        CAPTURE(mean, error, emitter.area);
        CHECK(std::abs(mean - emitter.area) <= 4 * error + 1e-5 * emitter.area);
    }
}

TEST_CASE("invalid pixels of an image light are reported with their position and are dark", "[lights]") {
    const std::string name = "raylex_sky_" + std::to_string(std::random_device{}()) + ".pfm";
    const auto path = std::filesystem::temp_directory_path() / name;
    std::ofstream file(path, std::ios::binary);
    file << "Pf\n2 2\n-1.0\n";
    const float rows[] = {1, -1, std::numeric_limits<float>::quiet_NaN(), 3};  // from the bottom
    file.write(reinterpret_cast<const char*>(rows), sizeof(rows));
    file.close();
    auto scene = import_pbrt_text("WorldBegin\nLightSource \"infinite\" \"string filename\" \"" + path.string() + "\"",
                                  "test.pbrt");
    REQUIRE(scene.ok());
    TextureTable textures;
    auto geometry = EmbreeScene::build(*scene, textures, {});
    std::vector<Error> warnings;
    const auto lights = LightTable::build(*scene, *geometry, warnings);
    std::filesystem::remove(path);
    REQUIRE(lights.ok());
    REQUIRE(warnings.size() == 1);
    CHECK(warnings[0].line == 2);
    CHECK(warnings[0].message.find("2 values in 2 texels negative or not finite, first at column 0, row 0") !=
          std::string::npos);
    for (std::uint64_t i = 0; i < 1000; ++i) {
        const PixelSampler sampler(SamplerKind::independent, 4, 0, 0, i);
        LightSample s;
        REQUIRE(lights->sample(lights->chooser(LightChoice::mis), *geometry, Vec3(), 0, sampler.get_2d(0), s));
        REQUIRE((s.radiance.g >= 1 && std::isfinite(s.pdf)));
    }
}

TEST_CASE("lights refuse unsupported parameters, with a location", "[lights]") {
    for (const char* text :
         {"LightSource \"goniometric\"", "LightSource \"spot\" \"point3 from\" [1 1 1] \"point3 to\" [1 1 1]",
          "LightSource \"infinite\" \"string filename\" \"no such.exr\""}) {
        auto scene = import_pbrt_text(std::string("WorldBegin\n") + text, "test.pbrt");
        if (!scene) continue;  // the importer may refuse it first
        TextureTable textures;
        auto geometry = EmbreeScene::build(*scene, textures, {});
        REQUIRE(geometry.ok());
        std::vector<Error> warnings;
        auto lights = LightTable::build(*scene, *geometry, warnings);
        INFO(text);
        REQUIRE_FALSE(lights.ok());
        CHECK_FALSE(lights.error().message.empty());
    }
}
