// Roulette and splits by expected gain (paths/guide/guide_gains.h): the image stays what it is without them.
#include "transport/paths/guide/guide_gains.h"

#include "transport/directed_integrator.h"
#include "transport/enclosure.h"
#include "transport/guide/guide_support.h"

using namespace render_test;

namespace {

using transport::Real;

/// Closures draw directions. The number of rays depends on the place and the throughput, without any reason: most paths
/// end early, and few survivors count for many. In the same way, few vertices take light samples.
class PlantedRays final : public transport::DirectionSampler {
  public:
    /// `everywhere`: the number of rays; 0: it varies.
    explicit PlantedRays(Real everywhere = 0) : everywhere_(everywhere) {}
    [[nodiscard]] bool plans_rays() const override { return true; }
    [[nodiscard]] Real rays(const transport::Bsdf& /*bsdf*/, const transport::SurfacePoint& point,
                            Real throughput) const override {
        if (everywhere_ > 0) return everywhere_;
        const auto place = static_cast<int>(std::floor(10 * (point.position.x + point.position.y)));
        constexpr std::array<Real, 5> numbers{transport::least_survival, 0.4f, 2.5f, 1, transport::most_branches};
        const Real number = numbers[static_cast<std::size_t>((place % 5 + 5) % 5)];
        return throughput < 0.2f ? std::min(number, Real(1)) : number;
    }
    [[nodiscard]] Real light_share(const transport::SurfacePoint& point, Real throughput) const override {
        const auto place = static_cast<int>(std::floor(10 * (point.position.x - point.position.y)));
        constexpr std::array<Real, 3> shares{transport::least_survival, 0.3f, 1};
        return throughput < 0.2f ? Real(0.5) : shares[static_cast<std::size_t>((place % 3 + 3) % 3)];
    }
    [[nodiscard]] transport::BsdfSample sample(const transport::Bsdf& bsdf, const transport::SurfacePoint& point,
                                               transport::TransportMode mode, Real u_lobe,
                                               const transport::Vec2& u) const override {
        transport::BsdfSample s = bsdf.sample(point.wo, u_lobe, u);
        s.is_weighed = mode == transport::TransportMode::radiance;
        return s;
    }
    [[nodiscard]] Real pdf(const transport::Bsdf& /*bsdf*/, const transport::SurfacePoint& /*point*/,
                           transport::TransportMode /*mode*/, const transport::Vec3& /*to*/,
                           Real closure_pdf) const override {
        return closure_pdf;
    }

  private:
    Real everywhere_;
};

/// Beauty and one channel for each number of reflections up to 8, and the light of each in the enclosure.
std::vector<double> request_lengths(transport::RenderSettings& settings, double kd, double ks) {
    settings.paths.max_depth = 8;
    std::vector<double> values{0};
    std::string expression = "C";
    for (std::size_t length = 0; length <= 8; ++length) {
        values.push_back(std::pow(kd + ks, static_cast<double>(length)));
        values[0] += values.back();
        settings.channels.list.push_back(lpe_channel("l" + std::to_string(length), expression + "L"));
        expression += "[DS]";
    }
    return values;
}

/// `t`: how many standard errors a mean may be off.
void check_lengths(const Replicates& found, const std::vector<double>& values, double t) {
    for (std::size_t i = 0; i < values.size(); ++i) {
        const Estimate e = found.channel(i);
        CAPTURE(i, values[i], e.mean, e.error);
        CHECK(std::abs(e.mean - values[i]) <= t * e.error + 1e-5);  // 1e-5: products of a few floats
    }
}

}  // namespace

TEST_CASE("no survival is below a twentieth, and no vertex has more than eight branches", "[guide][gain]") {
    transport::GuideTree::Region region;
    for (const float by_square : {0.0f, 1e-9f, 0.3f, 1.0f, 40.0f, 1e12f})
        for (const float noisy : {0.0f, 0.5f, 1.0f})
            for (const Real throughput : {0.0f, 1e-9f, 0.01f, 1.0f, 1e6f}) {
                region.by_square = by_square;
                region.by_noise = by_square * noisy;
                const Real rays = transport::rays_by_gain(region, throughput, false);
                CHECK(rays >= transport::least_survival);
                CHECK(rays <= 8);
                if (by_square * throughput >= 1) CHECK(rays >= 1);
                const Real in_training = transport::rays_by_gain(region, throughput, true);
                CHECK(in_training >= 0.25f);
                CHECK(in_training <= (by_square * throughput >= 1 ? rays : 1));
                region.by_light = by_square;
                const Real share = transport::light_share_by_gain(region, throughput);
                CHECK(share >= transport::least_survival);
                CHECK(share <= 1);
            }
    // m rays in the image, and sqrt(m) in training.
    region.by_square = region.by_light = 0.25f;
    CHECK(transport::rays_by_gain(region, 1, false) == 0.25f);
    CHECK(transport::rays_by_gain(region, 1, true) == 0.5f);
    CHECK(transport::light_share_by_gain(region, 1) == 0.25f);
    region.by_square = region.by_noise = 4;
    CHECK(transport::rays_by_gain(region, 1, false) == 4);
    CHECK(transport::rays_by_gain(region, 1, true) == 2);
}

TEST_CASE("roulette and splits by expected gain find the light of every length in an enclosure",
          "[guide][gain][render][gate]") {
    const double kd = 0.5, ks = 0.3;
    const auto scene = transport::BuiltScene::build(scene_of(enclosure(kd, ks)));
    REQUIRE(scene.ok());
    transport::RenderSettings settings = guided_settings(16, 256);
    const std::vector<double> values = request_lengths(settings, kd, ks);
    // Student's t with 7 degrees of freedom: beyond 9 by chance once in 20,000 comparisons.
    check_lengths(replicates(**scene, settings, static_cast<int>(values.size()), 8, 1), values, 9);
}

TEST_CASE("short renders are unbiased where survivors are rare and branches many",
          "[guide][gain][render][gate][statistical]") {
    register_directed("path-with-planted-rays", "path", std::make_shared<PlantedRays>());
    const double kd = 0.5, ks = 0.3;
    const auto scene = transport::BuiltScene::build(scene_of(enclosure(kd, ks)));
    REQUIRE(scene.ok());
    transport::RenderSettings settings;
    settings.paths.integrator = integrator_named("path-with-planted-rays");
    settings.samples.per_pixel = 1;
    settings.machine.threads = 2;
    const std::vector<double> values = request_lengths(settings, kd, ks);
    // 600 renders of one sample: Student's t beyond 5 by chance less than once in 10^5 comparisons.
    check_lengths(replicates(**scene, settings, static_cast<int>(values.size()), 600, 1), values, 5);
    CHECK(render_of(scene_of(enclosure(kd, ks)), settings).statistics.branches > 0);
}

TEST_CASE("a number of rays that is planned replaces the roulette by throughput, also where a mirror lobe is drawn",
          "[guide][gain][render][gate][statistical]") {
    // If the same number decided both, weak paths by the mirror would be 1 / 0.9 times too bright.
    register_directed("path-with-nine-tenths", "path", std::make_shared<PlantedRays>(Real(0.9)));
    const double kd = 0.1, ks = 0.3;
    const auto scene = transport::BuiltScene::build(scene_of(enclosure(kd, ks)));
    REQUIRE(scene.ok());
    transport::RenderSettings settings;
    settings.paths.integrator = integrator_named("path-with-nine-tenths");
    settings.samples.per_pixel = 16;
    settings.machine.threads = 2;
    const std::vector<double> values = request_lengths(settings, kd, ks);
    // 100 renders: Student's t beyond 5 by chance less than once in 10^5 comparisons.
    const Replicates found = replicates(**scene, settings, static_cast<int>(values.size()), 100, 1);
    check_lengths(found, values, 5);
    CHECK(5 * found.channel(4).error < 0.05 * values[4]);  // three reflections would be 8 % too bright
}

TEST_CASE("few light samples find the light of an area, a spot and the sky, also in fog",
          "[guide][gain][render][gate][statistical]") {
    register_directed("path-with-few-light-samples", "path", std::make_shared<PlantedRays>());
    for (const std::string& text : {room, foggy_room()}) {
        const auto scene = transport::BuiltScene::build(scene_of(text));
        REQUIRE(scene.ok());
        transport::RenderSettings settings;
        settings.machine.threads = 2;
        settings.samples.per_pixel = 64;
        settings.channels.list = {lpe_channel("direct", "C.L"), lpe_channel("indirect", "C..+L")};
        settings.paths.integrator = integrator_named("path-with-few-light-samples");
        const Replicates few = replicates(**scene, settings, 3, 40, 500);
        settings.paths.integrator = integrator_named("path");
        check_agreement(replicates(**scene, settings, 3, 40, 100), few, {"beauty", "direct", "indirect"});
    }
}

TEST_CASE("a guide leaves out light samples that glass blocks", "[guide][gain][render]") {
    const auto left_out = [](const std::string& text) {
        const auto output = render_of(scene_of(text), guided_settings(32, 16));
        CHECK(output.statistics.guide.used);
        const auto count = [&](transport::Pruned cause) {
            return static_cast<double>(output.statistics.pruned[static_cast<std::size_t>(cause)]);
        };
        const double left = count(transport::Pruned::light_samples_left_to_rays);
        return left / (left + static_cast<double>(output.statistics.shadow_rays));
    };
    // In the globe, the least probability is a twentieth. Lamps that light samples reach keep most of them.
    CHECK(left_out(lamp_in_globe(0.35, 0.2, 20)) > 0.9);
    CHECK(left_out(room) < 0.5);
}

TEST_CASE("roulette and splits by expected gain estimate the image of plain paths",
          "[guide][gain][render][gate][statistical]") {
    for (const std::string& text : {room, foggy_room(), lamp_in_globe(0.35, 0.2, 20)}) {
        const auto scene = transport::BuiltScene::build(scene_of(text));
        REQUIRE(scene.ok());
        transport::RenderSettings settings = guided_settings(32, 64);
        settings.channels.list = {lpe_channel("direct", "C.L"), lpe_channel("indirect", "C..+L")};
        const Replicates by_gain = replicates(**scene, settings, 3, 12, 500);
        settings.paths.integrator = integrator_named("path");
        const Replicates plain = replicates(**scene, settings, 3, 12, 100);
        check_agreement(plain, by_gain, {"beauty", "direct", "indirect"});
        settings.paths.integrator = guided_settings(32, 64).paths.integrator;
        settings.paths.integrator->parameters.parameters.push_back(text_parameter("guideroulette", "throughput"));
        CHECK(replicates(**scene, settings, 3, 1, 500).mean(0) != by_gain.mean(0));
    }
}

TEST_CASE("renders by expected gain have the same bits for every number of threads", "[guide][gain][render][law3]") {
    const auto scene = scene_of(foggy_room());
    transport::RenderSettings settings = guided_settings(8, 16);
    settings.machine.threads = 1;
    const auto one = render_of(scene, settings);
    CHECK(one.statistics.guide.used);
    CHECK(one.statistics.branches > 0);
    for (const int threads : {2, 3, 8}) {
        settings.machine.threads = threads;
        CHECK((frame_bits(render_of(scene, settings)) == frame_bits(one)));
    }
}

TEST_CASE("a resumed render by expected gain has the bits of a whole one", "[guide][gain][render][checkpoint][law3]") {
    const auto scene = scene_of(room);
    transport::RenderSettings settings = guided_settings(16, 100);
    settings.paths.integrator = with_guide(counted("path"), "on", 64);
    const auto whole = render_of(scene, settings);
    CHECK(whole.statistics.branches > 0);
    const ScratchFile file;
    const RenderInSessions found = render_in_sessions(scene, settings, 12'000, file.path());
    CHECK(found.sessions > 2);
    CHECK((frame_bits(found.output) == frame_bits(whole)));
}

TEST_CASE("layers of a render by expected gain sum to its beauty, and change nothing of it",
          "[guide][gain][render][law1][law2]") {
    const auto scene = scene_of(room);
    transport::RenderSettings settings = guided_settings(8, 16);
    const auto alone = render_of(scene, settings);
    settings.channels.list = {lpe_channel("seen", "C[LBO]"), lpe_channel("direct", "C.[LBO]"),
                              lpe_channel("indirect", "C..+[LBO]"), lpe_channel("caustics", "C<RD><TS>+L")};
    const auto beside = render_of(scene, settings);
    const std::vector<double> beauty = beside.frame_buffer.resolve(beside.beauty);
    CHECK(alone.frame_buffer.resolve(alone.beauty) == beauty);
    const std::vector<double> seen = beside.frame_buffer.resolve(1), direct = beside.frame_buffer.resolve(2),
                              indirect = beside.frame_buffer.resolve(3);
    double worst = 0;
    for (std::size_t i = 0; i < beauty.size(); ++i) {
        const double sum = seen[i] + direct[i] + indirect[i];
        if (sum + beauty[i] > 0) worst = std::max(worst, std::abs(sum - beauty[i]) / (sum + beauty[i]));
    }
    CHECK(worst <= 1e-12);  // Law 1's bound for the double accumulators
}
