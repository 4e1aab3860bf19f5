// Another sampler of directions than the closure (paths/direction_sampler.h): its densities integrate to 1, and paths
// that it draws estimate the same image with every method.
#include <numbers>

#include "tests/transport/materials_support.h"
#include "transport/directed_integrator.h"
#include "transport/enclosure.h"

using namespace render_test;

namespace {

using transport::Bsdf;
using transport::BsdfSample;
using transport::Real;
using transport::SurfacePoint;
using transport::TransportMode;
using transport::Vec2;
using transport::Vec3;

/// Draws from the closure or uniformly over the sphere, as a coin falls, with the density of both (a one-sample
/// mixture). Paths of radiance and of importance use different coins, so that tests notice which density is asked for.
class UniformMixture final : public transport::DirectionSampler {
  public:
    [[nodiscard]] BsdfSample sample(const Bsdf& bsdf, const SurfacePoint& point, TransportMode mode, Real u_lobe,
                                    const Vec2& u) const override {
        const Real share = closure_share(mode);
        BsdfSample s;
        if (u_lobe < share) {
            s = bsdf.sample(point.wo, u_lobe / share, u);
            if (!(s.pdf > 0)) return s;
            if (s.delta) {
                s.pdf *= share;
                s.weight *= 1 / share;
                return s;
            }
        } else {
            s.wi = transport::sample_uniform_sphere(u);
        }
        s.pdf = pdf(bsdf, point, mode, s.wi, bsdf.pdf(point.wo, s.wi));
        return s;
    }
    [[nodiscard]] Real pdf(const Bsdf& /*bsdf*/, const SurfacePoint& /*point*/, TransportMode mode, const Vec3& /*to*/,
                           Real closure_pdf) const override {
        const Real share = closure_share(mode);
        return share * closure_pdf + (1 - share) * transport::uniform_sphere_pdf();
    }

  private:
    static Real closure_share(TransportMode mode) { return mode == TransportMode::radiance ? 0.5f : 0.75f; }
};

/// Registers "guided-NAME" for each method. Parameters are those of the method.
void register_guided() {
    for (const std::string name : {"path", "lighttracer", "bdpt"})
        register_directed("guided-" + name, name, std::make_shared<UniformMixture>());
}

transport::RenderSettings by(const std::string& integrator, std::uint64_t samples) {
    transport::RenderSettings settings;
    settings.paths.integrator = integrator_named(integrator);
    settings.samples.per_pixel = samples;
    return settings;
}

}  // namespace

TEST_CASE("the density of a mixture of closure and sphere integrates to 1", "[directions]") {
    const UniformMixture mixture;
    Bsdf closures[2];
    const raylex::test::Frame frame = raylex::test::tilted_frame();
    closures[0].set(frame, transport::LambertClosure{transport::Rgb(0.6f)});
    closures[1].set_phase(0.4f);
    for (const Bsdf& bsdf : closures)
        for (const TransportMode mode : {TransportMode::radiance, TransportMode::importance}) {
            SurfacePoint point;
            point.wo = frame.to_world(raylex::test::local_direction(0.6f));
            // The midpoint rule over a sphere of 512 x 1024 cells of equal size. The kink of the Lambertian lobe at the
            // horizon crosses 1,000 cells or so, each of which is wrong by less than 1e-3 / 512 of the whole.
            constexpr int rings = 512, sectors = 1024;
            double sum = 0;
            for (int i = 0; i < rings; ++i)
                for (int k = 0; k < sectors; ++k) {
                    const Vec2 u{(static_cast<Real>(i) + 0.5f) / rings, (static_cast<Real>(k) + 0.5f) / sectors};
                    const Vec3 to = transport::sample_uniform_sphere(u);
                    sum += double{mixture.pdf(bsdf, point, mode, to, bsdf.pdf(point.wo, to))};
                }
            sum *= 4 * std::numbers::pi / (rings * sectors);
            CHECK(sum == Approx(1).margin(1e-4));
            raylex::test::Random random(7);
            for (int i = 0; i < 100; ++i) {
                const BsdfSample s = mixture.sample(bsdf, point, mode, random.one(), random.two());
                CHECK(s.pdf == mixture.pdf(bsdf, point, mode, s.wi, bsdf.pdf(point.wo, s.wi)));
            }
        }
}

TEST_CASE("paths drawn by another sampler than the closure estimate the same image",
          "[directions][mis][render][gate]") {
    register_guided();
    // Diffuse, glossy, coated and clear glass, lights of all kinds; then the same in fog.
    for (const bool fog : {false, true}) {
        const auto scene = transport::BuiltScene::build(scene_of(fog ? foggy_room() : room));
        REQUIRE(scene.ok());
        for (const char* method : {"path", "bdpt"}) {
            // Pixels of bdpt share light paths, so errors come from seeds: 8 of them, Student's t with 14 degrees of
            // freedom. Beyond 6.5 by chance once in 70,000 comparisons.
            const Replicates plain = replicates(**scene, by(method, 16), 1, 8, 1),
                             guided = replicates(**scene, by(std::string("guided-") + method, 16), 1, 8, 101);
            const Estimate a = plain.channel(0), b = guided.channel(0);
            CAPTURE(fog, method, a.mean, a.error, b.mean, b.error);
            CHECK(a.mean > 0);
            // With the numbers of the same seed, each mean would be the same if closures drew the directions.
            CHECK(replicates(**scene, by(std::string("guided-") + method, 16), 1, 1, 1).of_seed[0] != plain.of_seed[0]);
            CHECK(deviation(a, b) < 6.5);
        }
    }
}

TEST_CASE("in an enclosure another sampler than the closure finds the light of every word",
          "[directions][render][gate]") {
    register_guided();
    const double kd = 0.5, ks = 0.3;
    const auto scene = transport::BuiltScene::build(scene_of(enclosure(kd, ks)));
    REQUIRE(scene.ok());
    const std::vector<EnclosurePathString> words = enclosure_path_strings(kd, ks, 3);
    for (const char* method : {"guided-path", "guided-bdpt", "guided-lighttracer"}) {
        transport::RenderSettings settings = by(method, 64);
        settings.paths.max_depth = 3;
        for (const EnclosurePathString& word : words)
            settings.channels.list.push_back(lpe_channel("w" + word.reflections, "C" + word.reflections + "L"));
        const Replicates found = replicates(**scene, settings, static_cast<int>(words.size()) + 1, 8, 1);
        for (std::size_t i = 0; i < words.size(); ++i) {
            const bool lighttracer = std::string(method) == "guided-lighttracer";
            if (lighttracer && !light_tracer_finds(words[i])) continue;
            const Estimate e = found.channel(i + 1);
            CAPTURE(method, words[i].reflections, words[i].value, e.mean, e.error);
            // Student's t with 7 degrees of freedom: beyond 9 by chance once in 20,000 comparisons. 1e-5: products of
            // a few floats.
            CHECK(std::abs(e.mean - words[i].value) <= 9 * e.error + 1e-5);
        }
    }
}
