// Choosing among many lights by their contribution to a point.
#include <cmath>
#include <numeric>
#include <random>

#include "transport/lights/light_table.h"
#include "transport/replicates.h"

using namespace render_test;
using transport::LightChoice;
using transport::LightChooser;
using transport::LightReceiver;
using transport::LightSample;
using transport::LightTree;
using transport::Real;
using transport::Vec2;
using transport::Vec3;

namespace {

class Numbers {
  public:
    explicit Numbers(unsigned seed) : engine_(seed) {}
    double in(double from, double to) { return std::uniform_real_distribution<double>(from, to)(engine_); }
    Real unit() { return static_cast<Real>(std::uniform_int_distribution<int>(0, (1 << 24) - 1)(engine_)) * 0x1p-24f; }
    Vec3 direction() {
        for (;;) {
            const Vec3 v{static_cast<Real>(in(-1, 1)), static_cast<Real>(in(-1, 1)), static_cast<Real>(in(-1, 1))};
            if (const Real l2 = transport::length_squared(v); l2 > 0.01f && l2 <= 1) return normalize(v);
        }
    }
    Vec3 point(double reach) {
        return {static_cast<Real>(in(-reach, reach)), static_cast<Real>(in(-reach, reach)),
                static_cast<Real>(in(-reach, reach))};
    }

  private:
    std::mt19937 engine_;
};

/// Random lights of every kind, with and without positions.
std::string strewn(int count, unsigned seed) {
    Numbers numbers(seed);
    const auto place = [&] {
        return "Translate " + std::to_string(numbers.in(-5, 5)) + " " + std::to_string(numbers.in(0.2, 4)) + " " +
               std::to_string(numbers.in(-5, 5)) + "\nRotate " + std::to_string(numbers.in(0, 360)) + " 1 2 3\n";
    };
    static const std::array<std::string, 8> kinds{
        R"(AreaLightSource "diffuse" Shape "trianglemesh" "point3 P" [0 0 0 .2 0 0 0 .2 0])",
        R"(AreaLightSource "diffuse" "bool twosided" true Shape "trianglemesh" "point3 P" [0 0 0 .2 0 0 0 .2 0])",
        R"(AreaLightSource "diffuse" Shape "bilinearmesh" "point3 P" [0 0 0 .2 0 0 0 .2 0 .2 .2 .1])",
        R"(AreaLightSource "diffuse" Shape "sphere" "float radius" 0.1)",
        R"(AreaLightSource "diffuse" Shape "disk" "float radius" 0.1)",
        R"(AreaLightSource "diffuse" Shape "cylinder" "float radius" 0.1 "float zmin" -0.1 "float zmax" 0.1)",
        R"(LightSource "point" "rgb I" [.1 .1 .1])",
        R"(LightSource "spot" "rgb I" [.3 .3 .3] "float coneangle" 40 "point3 to" [0 -1 0])"};
    std::string text =
        "LightSource \"distant\" \"rgb L\" [.1 .1 .1]\nMaterial \"diffuse\" \"rgb reflectance\" [0 0 0]\n";
    for (int i = 0; i < count; ++i)
        text += "AttributeBegin\n" + place() + kinds[static_cast<std::size_t>(i) % kinds.size()] + "\nAttributeEnd\n";
    return text;
}

std::shared_ptr<const transport::BuiltScene> built(const std::string& world) {
    auto scene = transport::BuiltScene::build(scene_of(film +
                                                       "LookAt 0 3 -9  0 1 0  0 1 0\nCamera \"perspective\" "
                                                       "\"float fov\" 50\nWorldBegin\n" +
                                                       world));
    INFO((scene ? std::string() : scene.error().to_string()));
    REQUIRE(scene.ok());
    return *scene;
}

LightChooser chooser_of(const transport::BuiltScene& scene) {
    const auto view = scene.view();
    return LightChooser::by_receiver(view.lights->lights(), *view.geometry, LightChoice::mis);
}

}  // namespace

TEST_CASE("the probabilities of choices by receiver sum to 1, and choices match them", "[lights][light_tree]") {
    const auto scene = built(strewn(96, 1));
    const LightChooser chooser = chooser_of(*scene);
    const std::size_t count = scene->view().lights->lights().size();
    Numbers numbers(2);
    for (int trial = 0; trial < 12; ++trial) {
        const LightReceiver receiver(numbers.point(5), trial % 3 == 0 ? Vec3() : numbers.direction());
        std::vector<double> expected(count), found(count);
        for (std::uint32_t i = 0; i < count; ++i) expected[i] = chooser.probability(receiver, i);
        // The rest are descents that end in groups that send nothing to the receiver, although their bounds allow it.
        const double sum = std::accumulate(expected.begin(), expected.end(), 0.0);
        CHECK(sum > 0.5);       // the distant light alone has half
        CHECK(sum < 1 + 1e-4);  // products of at most 20 quotients of floats
        expected.push_back(std::max(1 - sum, 0.0));
        found.push_back(0);
        constexpr int draws = 20000;
        for (int i = 0; i < draws; ++i) {
            Vec2 u{numbers.unit(), numbers.unit()};
            const LightTree::Chosen chosen = chooser.choose(receiver, numbers.unit(), u);
            if (chosen.light != LightTree::none)
                REQUIRE(chosen.probability == Approx(expected[chosen.light]).epsilon(1e-6));
            found[std::min<std::size_t>(chosen.light, count)] += 1;
        }
        double chi2 = 0, rest_found = 0, rest_expected = 0;
        int degrees = 0;
        for (std::size_t i = 0; i <= count; ++i) {
            const double e = expected[i] * draws;
            if (e < 8) {
                rest_found += found[i];
                rest_expected += e;
                continue;
            }
            chi2 += (found[i] - e) * (found[i] - e) / e;
            ++degrees;
        }
        if (rest_expected >= 8) chi2 += (rest_found - rest_expected) * (rest_found - rest_expected) / rest_expected;
        // Normal approximation of chi-squared; 5 standard deviations are exceeded once in a million.
        CHECK(chi2 < degrees + 5 * std::sqrt(2.0 * degrees) + 10);
    }
}

TEST_CASE("every light that reaches a point can be chosen there", "[lights][light_tree]") {
    const auto scene = built(strewn(160, 3));
    const auto view = scene->view();
    const LightChooser chooser = chooser_of(*scene);
    Numbers numbers(4);
    std::size_t reaching = 0, left_out = 0;
    for (std::uint32_t light = 0; light < view.lights->lights().size(); ++light) {
        std::vector<std::uint8_t> alone(view.lights->lights().size(), 0);
        alone[light] = 1;
        const LightChooser only(view.lights->lights(), LightChoice::mis, alone);
        for (int i = 0; i < 200; ++i) {
            const LightReceiver receiver(numbers.point(6), numbers.direction());
            LightSample sample;
            if (!view.lights->sample(only, *view.geometry, receiver, numbers.unit(), {numbers.unit(), numbers.unit()},
                                     sample))
                continue;
            if (sample.radiance.is_black() || std::abs(dot(sample.wi, receiver.normal)) < 1e-3f) continue;
            ++reaching;
            left_out += !(chooser.probability(receiver, light) > 0);
        }
    }
    CHECK(reaching > 5000);
    CHECK(left_out == 0);
}

TEST_CASE("choices by receiver follow what lights send there", "[lights][light_tree]") {
    // Small random triangles of four powers above a floor, half of them two-sided. The contribution of each to a point
    // is known, and with the probabilities the variance of choosing one of them, over the squared mean.
    Numbers numbers(11);
    std::string world;
    for (int i = 0; i < 400; ++i) {
        const auto coordinate = [&](double from, double to) { return std::to_string(numbers.in(from, to)) + " "; };
        const double radiance = std::pow(4.0, i % 4);
        world += "AttributeBegin\nTranslate " + coordinate(-1.8, 1.8) + coordinate(-1.8, 1.8) + coordinate(0.1, 0.6) +
                 "\nAreaLightSource \"diffuse\" \"rgb L\" [" + std::to_string(radiance) + " " +
                 std::to_string(radiance) + " " + std::to_string(radiance) + "] \"bool twosided\" " +
                 (i % 8 < 4 ? "true" : "false") + "\nShape \"trianglemesh\" \"point3 P\" [";
        for (int k = 0; k < 9; ++k) world += coordinate(-0.02, 0.02);
        world += "]\nAttributeEnd\n";
    }
    const auto scene = built(world);
    const auto view = scene->view();
    const LightChooser chooser = chooser_of(*scene);
    const Vec3 origin = view.geometry->space().origin.to_real();
    double choosing = 0, all = 0;
    for (int i = 0; i < 200; ++i) {
        const Vec3 on_floor{static_cast<Real>(numbers.in(-2, 2)), static_cast<Real>(numbers.in(-2, 2)), 0};
        const LightReceiver receiver(on_floor - origin, {0, 0, 1});
        double sum = 0, squares = 0;
        for (std::uint32_t light = 0; light < view.lights->lights().size(); ++light) {
            const transport::Light& from = view.lights->lights()[light];
            const Vec3 way = from.position + (from.edge1 + from.edge2) / 3 - receiver.position;
            const double leaving = double{-dot(way, from.direction)}, arriving = double{dot(way, receiver.normal)};
            const double cosines = (from.two_sided ? std::abs(leaving) : std::max(leaving, 0.0)) * arriving;
            const double sent = double{from.emission.g} * double{from.area} * cosines /
                                std::pow(double{transport::length_squared(way)}, 2);
            if (!(sent > 0)) continue;
            sum += sent;
            squares += sent * sent / double{chooser.probability(receiver, light)};
        }
        choosing += squares - sum * sum;
        all += sum * sum;
    }
    CAPTURE(choosing / all);
    // Choosing by power leaves about 17, by bounds (as pbrt-v4 does) about 4, by expected contribution about 0.4. The
    // limit separates the last two for all drawn points.
    CHECK(choosing < all);
}

TEST_CASE("images with every choice of lights agree, and the choice by receiver has the least noise",
          "[render][lights][light_tree]") {
    const std::string world =
        strewn(120, 5) +
        "LightSource \"infinite\" \"rgb L\" [.05 .05 .05]\nMaterial \"diffuse\"\n"
        "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" "
        "[-6 0 -6  -6 0 6  6 0 6  6 0 -6]\nShape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" "
        "[-6 0 6  -6 5 6  6 5 6  6 0 6]\nMakeNamedMedium \"haze\" \"string type\" "
        "\"homogeneous\" \"rgb sigma_s\" [.1 .1 .1] \"rgb sigma_a\" [0 0 0]\n"
        "AttributeBegin\nMaterial \"interface\"\nMediumInterface \"haze\" \"\"\nTranslate 2 1 0\n"
        "Shape \"sphere\" \"float radius\" 0.9\nAttributeEnd\n";
    const auto scene = built(world);
    transport::RenderSettings settings;
    settings.samples.per_pixel = 16;
    settings.channels.list = {lpe_channel("direct", "C<RD>L"), lpe_channel("again", "C<RD><RD>L"),
                              lpe_channel("haze", "CVL")};
    const auto by = [&](const std::string& choice, std::uint64_t seed) {
        settings.paths.integrator.emplace().type = "path";
        settings.paths.integrator->parameters.parameters = {text_parameter("lightsampler", choice)};
        return replicates(*scene, settings, 4, 10, seed);
    };
    const Replicates receiver = by("bvh", 0), power = by("power", 100), uniform = by("uniform", 200);
    for (std::size_t channel = 0; channel < 4; ++channel) {
        const Estimate a = receiver.channel(channel), b = power.channel(channel), c = uniform.channel(channel);
        CAPTURE(channel, a.mean, a.error, b.mean, b.error, c.mean, c.error);
        CHECK(a.mean > 0);
        // Student's t with at least 9 degrees of freedom: 6.6 is exceeded once in 10,000.
        CHECK(deviation(a, b) < 6.6);
        CHECK(deviation(a, c) < 6.6);
    }
    double least = 0, most = 0;
    for (std::size_t block = 0; block < blocks_across * blocks_across; ++block) {
        const std::size_t direct = blocks_across * blocks_across + block;
        least += receiver.variance(direct);
        most += power.variance(direct);
    }
    // The ratio is a tenth or less. A ratio of variances with 9 x 9 degrees of freedom, not all independent, is off by
    // more than a factor of 3 less than once in 1,000.
    CHECK(least * 3 < most);
}
