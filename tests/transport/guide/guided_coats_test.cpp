// A guide at coated surfaces (Bsdf::can_be_guided), whose pdf() is not the density of their samples, and whose values
// have pbrt's bias under rough coats.
#include "tests/transport/directed_integrator.h"
#include "tests/transport/materials_support.h"
#include "transport/guide/guide_support.h"
#include "transport/paths/guide/guide.h"
#include "transport/paths/guide/guide_sums.h"
#include "transport/paths/scattering.h"

using namespace render_test;

namespace {

using raylex::test::average;
using raylex::test::MeanAndError;
using raylex::test::Random;
using transport::Bsdf;
using transport::Rgb;
using transport::Vec3;

/// A guide whose regions prefer directions near `spot`, and any before the surface.
transport::Guide towards(const Vec3& normal, const Vec3& spot) {
    transport::GuideTree tree({{0, 0, 0}, {1, 1, 1}});
    Random random(1);
    for (int round = 0; round < 6; ++round) {
        transport::GuideSums sums(tree, 0);
        for (int i = 0; i < 2000; ++i) {
            const Vec3 around = transport::sample_uniform_sphere(random.two());
            // Half of the light comes from everywhere before the surface, so the coat keeps a share.
            sums.add({.position = {0.5f, 0.5f, 0.5f},
                      .normal = normal,
                      .direction =
                          i % 2 == 0 ? normalize(spot + around * transport::Real(0.45)) : normalize(normal + around),
                      .square = 1,
                      .density = 1,
                      .chance = 1,
                      .key = static_cast<std::uint64_t>(i)});
        }
        tree = refined(sums, {.finds = 10'000, .nodes = 10'000});
    }
    return transport::Guide(std::move(tree));
}

template <class Base>
Bsdf coated(const Base& base, float alpha, bool as_pbrt, std::uint32_t key, float medium = 0) {
    transport::LayeredClosure<Base> closure;
    closure.coat = {{transport::Ggx::from_alpha(alpha, alpha), 1.5f}, 0.01f, 0.4f, Rgb(medium), 400, 1, as_pbrt};
    closure.base = base;
    closure.key = key;
    Bsdf bsdf;
    bsdf.set(raylex::test::tilted_frame(), closure);
    return bsdf;
}

Bsdf coat_of_kind(int kind, std::uint32_t key) {
    const transport::LambertClosure white{Rgb(0.8f)};
    const transport::ConductorClosure metal{transport::Ggx::from_alpha(0.3f, 0.3f), Rgb(0.8f), Rgb(0), true};
    switch (kind) {
        case 0:
            return coated(white, 0, true, key);
        case 1:
            return coated(white, 0.4f, true, key);
        case 2:
            return coated(white, 0.4f, false, key);
        case 3:
            return coated(white, 0.2f, true, key, 0.5f);
        case 4:
            return coated(metal, 0, true, key);
        default:
            return coated(metal, 0.4f, true, key);
    }
}

/// Directions of closures, and a planned number of rays.
class EqualRays final : public transport::DirectionSampler {
  public:
    explicit EqualRays(transport::Real rays) : rays_(rays) {}
    [[nodiscard]] bool plans_rays() const override { return true; }
    [[nodiscard]] transport::Real rays(const Bsdf& bsdf, const transport::SurfacePoint& point,
                                       transport::Real throughput) const override {
        static_cast<void>(bsdf), static_cast<void>(point), static_cast<void>(throughput);
        return rays_;
    }
    [[nodiscard]] transport::BsdfSample sample(const Bsdf& bsdf, const transport::SurfacePoint& point,
                                               transport::TransportMode mode, transport::Real u_lobe,
                                               const transport::Vec2& u) const override {
        static_cast<void>(mode);
        auto s = transport::sample_scattering<transport::TransportMode::radiance>(bsdf, point, u_lobe, u);
        s.is_weighed = true;
        return s;
    }
    [[nodiscard]] transport::Real pdf(const Bsdf& bsdf, const transport::SurfacePoint& point,
                                      transport::TransportMode mode, const Vec3& to,
                                      transport::Real closure_pdf) const override {
        static_cast<void>(bsdf), static_cast<void>(point), static_cast<void>(mode), static_cast<void>(to);
        return closure_pdf;
    }

  private:
    transport::Real rays_;
};

/// A floor with a rough coat close below a wide lamp, which light samples and scattered rays find about equally.
const std::string floor_below_lamp = film + R"(
Integrator "path" "integer maxdepth" 1
LookAt 0 1 3  0 0.2 0  0 1 0
Camera "perspective" "float fov" 20
WorldBegin
Material "coateddiffuse" "rgb reflectance" [0.8 0.8 0.8] "float roughness" 0.4 "bool remaproughness" false
Shape "bilinearmesh" "point3 P" [-1 0 -1  1 0 -1  -1 0 1  1 0 1]
Material "diffuse" "rgb reflectance" [0 0 0]
AreaLightSource "diffuse" "rgb L" [1 1 1]
Shape "bilinearmesh" "point3 P" [-2 0.8 -2  2 0.8 -2  -2 0.8 2  2 0.8 2]
)";

/// The lamp in glass and a lamp before the ceiling, in a room of a rough coat, a smooth one, and coated metal.
std::string coated_room() {
    std::string scene = lamp_in_globe(0.3, 0.12, 60);
    const std::string walls = R"(Material "diffuse" "rgb reflectance" [0.6 0.6 0.6])";
    scene.replace(scene.find(walls), walls.size(),
                  R"(Material "coateddiffuse" "rgb reflectance" [0.6 0.6 0.6] "float roughness" 0.15)");
    scene.insert(scene.find("Shape \"bilinearmesh\""),
                 "Material \"coateddiffuse\" \"rgb reflectance\" [0.6 0.5 0.4] \"float roughness\" 0\n");
    scene.insert(scene.rfind("Shape \"bilinearmesh\""),
                 R"(Material "coatedconductor" "float interface.roughness" 0.1 "float conductor.roughness" 0.2 )");
    return scene + R"(
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [2 2 2]
  Shape "bilinearmesh" "point3 P" [-0.3 1.9 -0.3  0.3 1.9 -0.3  -0.3 1.9 0.3  0.3 1.9 0.3]
AttributeEnd
)";
}

}  // namespace

TEST_CASE("a guide's samples of coats have the means of the coats' own samples", "[guide][materials]") {
    const raylex::test::Frame frame = raylex::test::tilted_frame();
    const Vec3 spot = frame.to_world(raylex::test::local_direction(0.5f, 2.5f));
    const transport::Guide guide = towards(frame.n, spot);
    transport::SurfacePoint point;
    point.position = {0.5f, 0.5f, 0.5f};
    point.shading_normal = frame.n;
    point.wo = frame.to_world(raylex::test::local_direction(0.7f));
    REQUIRE(guide.tree().region(guide.tree().place_of(point.position, frame.n).region).share > 0.2f);
    const int kind = GENERATE(0, 1, 2, 3, 4, 5);
    CAPTURE(kind);
    // Light from near the spot, beside light from everywhere; `guided`: by the guide, otherwise by the coat.
    const auto reflected = [&](bool guided, bool near_spot, int count, std::uint64_t seed) {
        Random random(seed);
        return average(count, [&] {
            const Bsdf bsdf = coat_of_kind(kind, random.bits());
            const transport::Real u_lobe = random.one();
            const auto s = guided ? guide.sample(bsdf, point, transport::TransportMode::radiance, u_lobe, random.two())
                                  : bsdf.sample(point.wo, u_lobe, random.two());
            if (!(s.pdf > 0)) return 0.0;
            if (guided) CHECK(s.is_weighed);
            return near_spot && dot(s.wi, spot) < 0.9f ? 0.0 : double{s.weight.r};
        });
    };
    for (const bool near_spot : {false, true}) {
        const MeanAndError guided = reflected(true, near_spot, 200'000, 7),
                           own = reflected(false, near_spot, 200'000, 8);
        CAPTURE(near_spot, guided.mean, guided.standard_error, own.mean, own.standard_error);
        const double error = std::hypot(guided.standard_error, own.standard_error);
        CHECK(std::abs(guided.mean - own.mean) < 4.5 * error);
        // Pbrt's values are 9 % too large under the rough coats, and the guide draws most directions near the spot.
        CHECK(error < (near_spot ? 0.07 : 0.02) / 4.5 * own.mean);
        if (near_spot) CHECK(guided.standard_error < 0.95 * own.standard_error);
    }
}

TEST_CASE("at rough coats of pbrt a guide leaves the weights of light samples", "[guide][materials]") {
    const raylex::test::Frame frame = raylex::test::tilted_frame();
    const transport::Guide guide = towards(frame.n, frame.n);
    transport::SurfacePoint point;
    point.position = {0.5f, 0.5f, 0.5f};
    point.shading_normal = frame.n;
    point.wo = frame.to_world(raylex::test::local_direction(0.7f));
    constexpr auto radiance = transport::TransportMode::radiance;
    for (const bool as_pbrt : {true, false}) {
        const Bsdf bsdf = coated(transport::LambertClosure{Rgb(0.8f)}, 0.4f, as_pbrt, 5);
        const transport::Real own = bsdf.pdf(point.wo, frame.n);
        CHECK((guide.pdf(bsdf, point, radiance, frame.n, own) == own) == as_pbrt);
        Random random(3);
        for (int i = 0; i < 1000; ++i) {
            const auto s = guide.sample(bsdf, point, radiance, random.one(), random.two());
            if (s.pdf > 0) CHECK(s.pdf == guide.pdf(bsdf, point, radiance, s.wi, bsdf.pdf(point.wo, s.wi)));
        }
    }
}

TEST_CASE("the number of rays leaves the mean of rough coats of pbrt", "[guide][materials][render][statistical]") {
    const auto scene = transport::BuiltScene::build(scene_of(floor_below_lamp));
    REQUIRE(scene.ok());
    transport::RenderSettings settings;
    settings.samples.per_pixel = 64;
    settings.machine.threads = 2;
    settings.paths.integrator = integrator_named("path");
    const Estimate plain = replicates(**scene, settings, 1, 24, 100).channel(0);
    for (const transport::Real rays : {transport::Real(0.1), transport::Real(6)}) {
        register_directed("planted-rays", "path", std::make_shared<EqualRays>(rays));
        settings.paths.integrator = integrator_named("planted-rays");
        settings.samples.per_pixel = rays < 1 ? 512 : 64;  // few rays are noisy
        const Estimate planted = replicates(**scene, settings, 1, 24, 500).channel(0);
        CAPTURE(rays, plain.mean, plain.error, planted.mean, planted.error);
        // Student's t with 23 degrees of freedom: beyond 4.5 once in 6,000 comparisons.
        CHECK(std::abs(plain.mean - planted.mean) < 4.5 * std::hypot(plain.error, planted.error));
        // Light samples alone are 9 % too bright, so the mean changes by about 4 % where weights depend on rays.
        CHECK(std::hypot(plain.error, planted.error) < 0.015 / 4.5 * plain.mean);
    }
}

TEST_CASE("guided paths estimate the image of plain ones in a room of coats", "[guide][render][gate][statistical]") {
    const auto scene = transport::BuiltScene::build(scene_of(coated_room()));
    REQUIRE(scene.ok());
    transport::RenderSettings settings = guided_settings(64, 64);
    settings.channels.list = {lpe_channel("coat", "C<RG>.*L"), lpe_channel("base", "C<RD>.*L")};
    const Replicates guided = replicates(**scene, settings, 3, 12, 500);
    settings.samples.per_pixel = 1;
    const auto one = transport::render(**scene, settings);
    REQUIRE(one.ok());
    CHECK(one->statistics.guide.guided > 0.5);
    settings.samples.per_pixel = 64;
    settings.paths.integrator = with_guide(integrator_named("bdpt"), "on", 64);
    const Replicates bidirectional = replicates(**scene, settings, 3, 12, 900);
    settings.paths.integrator = integrator_named("bdpt");
    const Replicates plain_bidirectional = replicates(**scene, settings, 3, 12, 1300);
    settings.paths.integrator = integrator_named("path");
    settings.samples.per_pixel = 256;
    const Replicates plain = replicates(**scene, settings, 3, 12, 100);
    check_agreement(plain, guided, {"beauty", "coat", "base"});
    check_agreement(plain_bidirectional, bidirectional, {"beauty", "coat", "base"});
}
