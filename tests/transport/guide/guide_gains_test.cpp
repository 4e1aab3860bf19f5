// Roulette and splits by expected gain (paths/guide/guide_gains.h): the image stays what it is without them.
#include "transport/paths/guide/guide_gains.h"

#include "tests/transport/interrupted_render.h"
#include "transport/enclosure.h"
#include "transport/integrators/integrator.h"

using namespace render_test;

namespace {

using transport::Real;

transport::RenderSettings gain_settings(int training, std::uint64_t per_pixel, const std::string& roulette = "gain") {
    transport::RenderSettings settings;
    transport::SceneEntity path = integrator_named("path");
    path.parameters.parameters.push_back(text_parameter("guide", "on"));
    path.parameters.parameters.push_back(number_parameter("guidesamples", training));
    path.parameters.parameters.push_back(text_parameter("guideroulette", roulette));
    settings.paths.integrator = path;
    settings.samples.per_pixel = per_pixel;
    settings.machine.threads = 2;
    return settings;
}

std::string bits_of_frame(const transport::RenderOutput& output) {
    std::string bytes;
    output.frame_buffer.append_record(bytes);
    return bytes;
}

/// A closed box with a lamp in a globe of glass, which no light sample passes.
const std::string globe = film + R"(
Integrator "path" "integer maxdepth" 6
LookAt 0 1 3.9  0 1 0  0 1 0
Camera "perspective" "float fov" 39
WorldBegin
Material "diffuse" "rgb reflectance" [0.6 0.6 0.6]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-1 0 4 1 0 4 1 0 -1 -1 0 -1]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-1 2 -1 1 2 -1 1 2 4 -1 2 4]
Shape "bilinearmesh" "point3 P" [-1 0 -1 1 0 -1 -1 2 -1 1 2 -1]
Shape "bilinearmesh" "point3 P" [-1 0 4 1 0 4 -1 2 4 1 2 4]
Shape "bilinearmesh" "point3 P" [-1 0 -1 -1 0 4 -1 2 -1 -1 2 4]
Shape "bilinearmesh" "point3 P" [1 0 -1 1 0 4 1 2 -1 1 2 4]
AttributeBegin Translate 0.1 1.3 0.2
  AttributeBegin Material "dielectric" Shape "sphere" "float radius" 0.35 AttributeEnd
  AreaLightSource "diffuse" "rgb L" [20 20 20]
  Shape "sphere" "float radius" 0.2
AttributeEnd
)";

/// Closures draw directions. The number of rays depends on the place and the throughput, without any reason: most paths
/// end early, and few survivors count for many.
class PlantedRays final : public transport::DirectionSampler {
  public:
    [[nodiscard]] bool plans_rays() const override { return true; }
    [[nodiscard]] Real rays(const transport::Bsdf& /*bsdf*/, const transport::SurfacePoint& point,
                            Real throughput) const override {
        const auto place = static_cast<int>(std::floor(10 * (point.position.x + point.position.y)));
        constexpr std::array<Real, 5> numbers{transport::least_survival, 0.4f, 2.5f, 1, transport::most_branches};
        const Real number = numbers[static_cast<std::size_t>((place % 5 + 5) % 5)];
        return throughput < 0.2f ? std::min(number, Real(1)) : number;
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
};

/// `path`, prepared with PlantedRays.
class PlantedPath final : public transport::Integrator {
  public:
    explicit PlantedPath(std::unique_ptr<Integrator> inner) : inner_(std::move(inner)) {}
    [[nodiscard]] transport::IntegratorTraits traits() const override { return inner_->traits(); }
    raylex::Status prepare(const transport::IntegratorContext& context) override {
        transport::IntegratorContext planted = context;
        planted.directions = &rays_;
        return inner_->prepare(planted);
    }
    [[nodiscard]] std::unique_ptr<transport::IntegratorThread> make_thread_state() const override {
        return inner_->make_thread_state();
    }
    void integrate(const transport::CameraBatch& batch, transport::IntegratorThread& thread,
                   transport::ThreadServices& services) const override {
        inner_->integrate(batch, thread, services);
    }

  private:
    PlantedRays rays_;
    std::unique_ptr<Integrator> inner_;
};

void register_planted() {
    auto& registry = transport::integrator_registry();
    auto entry = *registry.find("path");
    entry.name = "path-with-planted-rays";
    entry.factory = [inner = entry.factory](const transport::SceneEntity& entity, std::optional<std::int64_t> max_depth)
        -> raylex::Result<std::unique_ptr<transport::Integrator>> {
        auto made = inner(entity, max_depth);
        if (!made) return made.error();
        return std::unique_ptr<transport::Integrator>(std::make_unique<PlantedPath>(*std::move(made)));
    };
    registry.add(std::move(entry));
}

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
                const Real rays = transport::rays_by_gain(region, throughput);
                CHECK(rays >= transport::least_survival);
                CHECK(rays <= 8);
                if (by_square * throughput >= 1) CHECK(rays >= 1);
            }
}

TEST_CASE("roulette and splits by expected gain find the light of every length in an enclosure",
          "[guide][gain][render][gate]") {
    const double kd = 0.5, ks = 0.3;
    const auto scene = transport::BuiltScene::build(scene_of(enclosure(kd, ks)));
    REQUIRE(scene.ok());
    transport::RenderSettings settings = gain_settings(16, 256);
    const std::vector<double> values = request_lengths(settings, kd, ks);
    // Student's t with 7 degrees of freedom: beyond 9 by chance once in 20,000 comparisons.
    check_lengths(replicates(**scene, settings, static_cast<int>(values.size()), 8, 1), values, 9);
}

TEST_CASE("short renders are unbiased where survivors are rare and branches many",
          "[guide][gain][render][gate][statistical]") {
    register_planted();
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

TEST_CASE("roulette and splits by expected gain estimate the image of plain paths",
          "[guide][gain][render][gate][statistical]") {
    for (const std::string& text : {room, foggy_room(), globe}) {
        const auto scene = transport::BuiltScene::build(scene_of(text));
        REQUIRE(scene.ok());
        transport::RenderSettings settings = gain_settings(32, 64);
        settings.channels.list = {lpe_channel("direct", "C.L"), lpe_channel("indirect", "C..+L")};
        const Replicates by_gain = replicates(**scene, settings, 3, 12, 500);
        settings.paths.integrator = integrator_named("path");
        const Replicates plain = replicates(**scene, settings, 3, 12, 100);
        check_agreement(plain, by_gain, {"beauty", "direct", "indirect"});
        settings.paths.integrator = gain_settings(32, 64, "throughput").paths.integrator;
        CHECK(replicates(**scene, settings, 3, 1, 500).mean(0) != by_gain.mean(0));
    }
}

TEST_CASE("renders by expected gain have the same bits for every number of threads", "[guide][gain][render][law3]") {
    const auto scene = scene_of(foggy_room());
    transport::RenderSettings settings = gain_settings(8, 16);
    settings.machine.threads = 1;
    const auto one = render_of(scene, settings);
    CHECK(one.statistics.guide.used);
    CHECK(one.statistics.branches > 0);
    for (const int threads : {2, 3, 8}) {
        settings.machine.threads = threads;
        CHECK((bits_of_frame(render_of(scene, settings)) == bits_of_frame(one)));
    }
}

TEST_CASE("a resumed render by expected gain has the bits of a whole one", "[guide][gain][render][checkpoint][law3]") {
    const auto scene = scene_of(room);
    transport::RenderSettings settings = gain_settings(8, 100);
    transport::SceneEntity counted_path = counted("path");
    for (const auto& each : settings.paths.integrator->parameters.parameters)
        counted_path.parameters.parameters.push_back(each);
    settings.paths.integrator = counted_path;
    const auto whole = render_of(scene, settings);
    CHECK(whole.statistics.branches > 0);
    const ScratchFile file;
    settings.checkpoint = transport::CheckpointSettings{.file = file.path(), .seconds = 0.01};
    for (int sessions = 1;; ++sessions) {
        std::atomic<bool> stop{false};
        interruption().begin(12'000, &stop);
        auto output = transport::render(scene, settings, {}, &stop);
        interruption().begin(0, nullptr);
        REQUIRE(output.ok());
        REQUIRE(sessions < 100);
        settings.checkpoint->resume = true;
        if (!output->samples.complete) continue;
        CHECK(sessions > 2);
        CHECK((bits_of_frame(*output) == bits_of_frame(whole)));
        break;
    }
}

TEST_CASE("layers of a render by expected gain sum to its beauty, and change nothing of it",
          "[guide][gain][render][law1][law2]") {
    const auto scene = scene_of(room);
    transport::RenderSettings settings = gain_settings(8, 16);
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
