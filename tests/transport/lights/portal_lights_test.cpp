// Portals: infinite lights that shine through a polygon.
#include <catch2/catch.hpp>

#include <cmath>
#include <numbers>

#include "tests/transport/image_file.h"
#include "tests/transport/lights/light_draws.h"
#include "tests/transport/lit_scene.h"

using namespace raylex;
using namespace raylex::transport;

namespace image_lights {

TEST_CASE("without an image a portal has the radiance L with its own luminance, as in pbrt", "[lights]") {
    const auto seen = [](const std::string& sky) {
        const Lit scene = lit("LightSource \"infinite\" " + sky +
                              " \"point3 portal\" [-1 -0.5 2  -1 0.5 2  1 0.5 2  1 -0.5 2]" + sphere_in_the_middle);
        return scene.lights.environment_radiance(0, {}, {0, 0, 1});
    };
    CHECK(luminance(seen("\"spectrum L\" [300 2 900 2]")) == Approx(2).epsilon(1e-4));
    CHECK(seen("\"rgb L\" [2 2 2]").g == Approx(2).epsilon(1e-5));
    // Planck's law over its maximum, weighted by the eye's sensitivity, over that sensitivity's sum, at 6500 K.
    // Computed independently of raylex with the CIE's y in steps of 10 nm, to four digits; 0.001 covers the steps.
    CHECK(luminance(seen("\"blackbody L\" [6500]")) == Approx(0.886).margin(0.001));
    CHECK(luminance(seen("\"blackbody L\" [6500] \"float illuminance\" 3")) == Approx(3 / (2 * pi_d)).epsilon(1e-4));
}

TEST_CASE("a portal in front of a white sky matches Lambert's polygon formula", "[lights]") {
    const std::string portal = "\"point3 portal\" [-1 -0.5 2  -1 0.5 2  1 0.5 2  1 -0.5 2]";
    const ::ImageFile white(16, 16, std::vector<Rgb>(256, Rgb(3)));
    const Vec3 corner[4] = {{-1, -0.5f, 2}, {-1, 0.5f, 2}, {1, 0.5f, 2}, {1, -0.5f, 2}};
    for (const std::string& sky : {"LightSource \"infinite\" \"rgb L\" [3 3 3] " + portal,
                                   "Rotate 50 1 2 3\nLightSource \"infinite\" " + portal + white.parameter()}) {
        INFO(sky);
        const Lit scene = lit(sky + sphere_in_the_middle);
        for (const Vec3& p : {Vec3{0, 0, 0}, Vec3{1.4f, 0.3f, 1}, Vec3{-3, -2, -4}}) {
            const Vec3 n = normalize(Vec3{0.2f, 0.1f, 1});
            double sum = 0;
            for (int i = 0; i < 4; ++i) {
                const DVec3 a = normalize(DVec3(corner[i]) - DVec3(p)),
                            b = normalize(DVec3(corner[(i + 1) % 4]) - DVec3(p));
                sum += std::acos(dot(a, b)) * dot(normalize(cross(a, b)), DVec3(n));
            }
            // The whole portal is above this plane. Only the cosine is random.
            const Mean found = irradiance(scene, p, n);
            CHECK(std::abs(found.value - 3 * std::abs(sum) / 2) < 4 * found.error + 1e-4 * found.value);
        }
        LightSample s;
        CHECK_FALSE(draw(scene, {0, 0, 2.5f}, 0, s));  // no light arrives outside
        CHECK(scene.lights.environment_radiance(0, {}, {0, 0, 1}).g == Approx(3).epsilon(1e-5));
        CHECK(scene.lights.environment_radiance(0, {}, {0, 0, -1}).is_black());
        CHECK(scene.lights.environment_radiance(0, {}, normalize(Vec3{1.1f, 0, 2})).is_black());
        CHECK(scene.lights.environment_radiance(0, {1, 0, 0}, normalize(Vec3{-1.9f, 0.4f, 2})).g ==
              Approx(3).epsilon(1e-5));
        // The power through the whole portal: pi L A.
        const Mean power = mean_of(1 << 14, [&](std::uint64_t i) {
            const PixelSampler sampler = numbers(i);
            EmissionSample e;
            if (!scene.lights.sample_emission(scene.lights.chooser(LightChoice::light_sampling), scene.geometry, 0,
                                              sampler.get_2d(2), sampler.get_2d(3), e))
                return 0.0;
            return static_cast<double>(e.power.g);
        });
        CHECK(std::abs(power.value - pi_d * 3 * 2) < 4 * power.error);
    }
}

TEST_CASE("portals draw directions by their image, with its density", "[lights]") {
    constexpr int n = 32;
    std::vector<Rgb> pixels(n * n, Rgb(0.2f));
    for (int i = 0; i < n * n; i += 11) pixels[static_cast<std::size_t>(i)] = Rgb(4, 2, 1);
    for (int i = 300; i < 340; ++i) pixels[static_cast<std::size_t>(i)] = Rgb(0);
    const ::ImageFile file(n, n, pixels);
    const Lit scene =
        lit("LightSource \"infinite\" \"point3 portal\" [-1 -1 1  -1 1 1  1 1 1  1 -1 1]" + file.parameter() +
            "AreaLightSource \"diffuse\" \"rgb L\" [4 4 4]\nTranslate 0 0 -9\nShape \"sphere\"");
    const LightChooser& chooser = scene.lights.chooser(LightChoice::mis);
    const std::uint32_t sky = scene.lights.environments()[0];
    for (const Vec3& from : {Vec3{0, 0, 0}, Vec3{2, 0.5f, 0.3f}}) {
        const double chosen = static_cast<double>(chooser.probability(from, sky));
        int found = 0;
        for (std::uint64_t i = 0; i < 4000; ++i) {
            LightSample s;
            if (!draw(scene, from, i, s) || s.light != sky) continue;
            ++found;
            const double again = static_cast<double>(scene.lights.environment_density(chooser, sky, from, s.wi));
            // At the border of a pixel or the portal, rounding may decide otherwise.
            if (std::abs(again / static_cast<double>(s.pdf) - 1) > 1e-3) --found;
            else CHECK(scene.lights.environment_radiance(sky, from, s.wi) == s.radiance);
        }
        CHECK(found > 4000 * chosen * 0.97);
        check_directions(
            [&](std::uint64_t i, Vec3& d) {
                LightSample s;
                if (!draw(scene, from, i, s) || s.light != sky) return false;
                d = s.wi;
                return true;
            },
            [&](const Vec3& d) {
                return static_cast<double>(scene.lights.environment_density(chooser, sky, from, d));
            });
    }
}

}  // namespace image_lights
