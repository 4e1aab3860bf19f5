// Rendered participating media, against closed forms and by the laws.
#include "transport/render_support.h"

#include <array>
#include <map>
#include <memory>
#include <mutex>

#include "display/buffer/sample_sink.h"
#include "display/deep/deep_buffer.h"

using namespace render_test;
using raylex::Rgb;

namespace {

/// A camera in the middle of a ball of fog with radius 1, in a uniform sky of radiance 1.
std::string ball(const std::string& medium,
                 const std::string& settings = "\"integer maxdepth\" 2000 \"bool roulette\" false",
                 const std::string& world = "LightSource \"infinite\" \"rgb L\" [1 1 1]") {
    return R"(
Film "rgb" "integer xresolution" 8 "integer yresolution" 8
PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
Sampler "independent" "integer pixelsamples" 64
Integrator "path" )" +
           settings + R"(
MakeNamedMedium "fog" "string type" "homogeneous" )" +
           medium + R"(
MediumInterface "" "fog"
Camera "perspective" "float fov" 60
WorldBegin
)" + world +
           R"(
MediumInterface "fog" ""
Material "interface"
Shape "sphere" "float radius" 1
)";
}

std::array<double, 3> mean_rgb(const transport::RenderOutput& output, display::ChannelId id) {
    const std::vector<double> values = output.frame_buffer.resolve(id);
    std::array<double, 3> mean{};
    for (std::size_t i = 0; i < values.size(); ++i) mean[i % 3] += values[i] / double(values.size() / 3);
    return mean;
}

/// Light scattered once towards the middle of a ball of radius 1 under a uniform sky of radiance 1: the integral over
/// the distance t of the scattering point and the cosine m of the direction from which it scatters light, by the
/// midpoint rule.
double scattered_once(double sigma_s, double sigma_t, double g) {
    constexpr int steps = 600;
    double sum = 0;
    for (int i = 0; i < steps; ++i) {
        const double t = (i + 0.5) / steps;
        for (int k = 0; k < steps; ++k) {
            const double m = -1 + (k + 0.5) * 2 / steps;  // of the sampled direction against the camera ray's own
            const double out = -t * m + std::sqrt(1 - t * t * (1 - m * m));
            const double phase = 0.5 * (1 - g * g) / std::pow(1 + g * g - 2 * g * m, 1.5);  // per unit of m
            sum += sigma_s * std::exp(-sigma_t * (t + out)) * phase * (2.0 / steps) / steps;
        }
    }
    return sum;
}

}  // namespace

TEST_CASE("a medium without absorption in a furnace is invisible, sample by sample", "[render][media]") {
    transport::RenderSettings settings;
    settings.channels.list = {lpe_channel("none", "CB"), lpe_channel("some", "CV+B"), lpe_channel("volume", "CV.*")};
    for (const char* g : {"0", "0.7", "-0.7"}) {
        const auto output = render_of(
            scene_of(ball("\"rgb sigma_a\" [0 0 0] \"rgb sigma_s\" [2 2 2] \"float g\" " + std::string(g))), settings);
        for (const double value : output.frame_buffer.resolve(output.beauty)) CHECK(value == 1.0);
        CHECK(std::abs(mean_rgb(output, 1)[0] + mean_rgb(output, 2)[0] - 1) <= 1e-12);
        CHECK(output.frame_buffer.resolve(2) == output.frame_buffer.resolve(3));
    }
}

TEST_CASE("coloured scattering without absorption keeps every colour in a furnace", "[render][media]") {
    const auto output = render_of(scene_of(ball("\"rgb sigma_a\" [0 0 0] \"rgb sigma_s\" [0.3 1 3]")));
    const std::vector<double> variances = output.frame_buffer.resolve_variance_of_mean(output.beauty);
    const std::array<double, 3> mean = mean_rgb(output, output.beauty);
    for (std::size_t c = 0; c < 3; ++c) {
        double variance = 0;
        for (std::size_t i = c; i < variances.size(); i += 3) variance += variances[i];
        const double error = std::sqrt(variance) / double(variances.size() / 3);
        CAPTURE(c, mean[c], error);
        CHECK(error < 0.03);
        CHECK(std::abs(mean[c] - 1) <= 4.5 * error);  // by chance once in 150,000
    }
}

TEST_CASE("a medium that only absorbs follows Beer-Lambert exactly, in light and alpha", "[render][media]") {
    transport::RenderSettings settings;
    settings.channels.list = {lpe_channel("seen", "CB")};
    const auto output = render_of(scene_of(ball("\"rgb sigma_a\" [0.5 1 2] \"rgb sigma_s\" [0 0 0]")), settings);
    const std::vector<double> values = output.frame_buffer.resolve(1);
    const double sigma[] = {0.5, 1, 2};
    double alpha = 0;
    for (const double s : sigma) alpha += (1 - std::exp(-s)) / 3;
    // The ray's length is a float near 1, the exponential a float: some ulps.
    for (std::size_t i = 0; i < values.size(); ++i) CHECK(values[i] == Approx(std::exp(-sigma[i % 3])).epsilon(2e-6));
    for (const double a : output.frame_buffer.resolve_alpha()) CHECK(a == Approx(alpha).epsilon(2e-6));
}

TEST_CASE("borders change the medium, cutouts and equal sides do not", "[render][media]") {
    // From the middle outwards: vacuum to 0.25, fog to 0.5, a cutout of opacity 0 at 0.6 that would end the fog if it
    // were a border, a surface with fog on both sides at 0.7, fog to 1.
    const std::string scene = R"(
Film "rgb" "integer xresolution" 4 "integer yresolution" 4
Sampler "independent" "integer pixelsamples" 16
MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_a" [1 1 1] "rgb sigma_s" [0 0 0]
MakeNamedMedium "dense" "string type" "homogeneous" "rgb sigma_a" [9 9 9] "rgb sigma_s" [0 0 0]
Camera "perspective"
WorldBegin
LightSource "infinite" "rgb L" [1 1 1]
Material "interface"
MediumInterface "" "fog"
Shape "sphere" "float radius" 0.25
MediumInterface "dense" "dense"
Shape "sphere" "float radius" 0.7
MediumInterface "fog" ""
Shape "sphere" "float radius" 1
Material "diffuse"
MediumInterface "" "dense"
Shape "sphere" "float radius" 0.6 "float alpha" 0
)";
    const auto output = render_of(scene_of(scene));
    for (const double value : output.frame_buffer.resolve(output.beauty))
        CHECK(value == Approx(std::exp(-0.75)).epsilon(4e-6));  // four segments, each some ulps
}

TEST_CASE("light scattered once has its closed form for every asymmetry", "[render][media]") {
    transport::RenderSettings settings;
    settings.samples.per_pixel = 1024;
    settings.channels.list = {lpe_channel("seen", "CB"), lpe_channel("once", "CVB"), lpe_channel("twice", "CVVB")};
    for (const double g : {0.0, 0.6, -0.6}) {
        const auto output =
            render_of(scene_of(ball("\"rgb sigma_a\" [0.2 0.2 0.2] \"rgb sigma_s\" [0.8 0.8 0.8] \"float g\" " +
                                        std::to_string(g),
                                    "\"integer maxdepth\" 2")),
                      settings);
        const Estimate seen = estimate(output, 1), once = estimate(output, 2);
        CAPTURE(g, seen.mean, once.mean, once.error, scattered_once(0.8, 1, g));
        CHECK(std::abs(seen.mean - std::exp(-1.0)) <= 4.5 * seen.error);
        CHECK(once.error < 0.003);
        CHECK(std::abs(once.mean - scattered_once(0.8, 1, g)) <= 4.5 * once.error);
    }
    // Backward scattering has a longer way: the three must differ, or g is not used.
    CHECK(std::abs(scattered_once(0.8, 1, 0.6) - scattered_once(0.8, 1, -0.6)) > 0.05);
}

TEST_CASE("emission in an unbounded medium has its closed form, order by order and without noise", "[render][media]") {
    // L of order k is albedo^k (1 - albedo) Le, for every extinction and asymmetry.
    const std::string scene = R"(
Film "rgb" "integer xresolution" 4 "integer yresolution" 4
Sampler "independent" "integer pixelsamples" 16
Integrator "path" "integer maxdepth" 3 "bool roulette" false
MakeNamedMedium "fire" "string type" "homogeneous" "rgb sigma_a" [0.5 0.5 0.5] "rgb sigma_s" [1.5 1.5 1.5] "rgb Le" [2 2 2]
    "float scale" 3 "float g" 0.4
MediumInterface "fire"
Camera "perspective"
WorldBegin
)";
    transport::RenderSettings settings;
    for (int k = 0; k <= 3; ++k)
        settings.channels.list.push_back(
            lpe_channel("o" + std::to_string(k), "C" + std::string(std::size_t(k), 'V') + "O"));
    settings.channels.list.push_back(lpe_channel("fourth", "CVVVVV*O"));
    const auto output = render_of(scene_of(scene), settings);
    for (int k = 0; k <= 3; ++k)
        for (const double value : output.frame_buffer.resolve(1 + k))
            CHECK(value == Approx(std::pow(0.75, k) * 0.25 * 2).epsilon(1e-6));
    for (const double value : output.frame_buffer.resolve(5)) CHECK(value == 0);
}

TEST_CASE("shadow rays are attenuated only by the media that they traverse", "[render][media]") {
    // A lamp in a ball of absorbing fog outside the camera's view: every shadow ray traverses 0.5 of it.
    const auto lit = [](const std::string& fog) {
        return scene_of(film + R"(
Integrator "path" "integer maxdepth" 1
LookAt 0 4 0.001  0 0 0  0 0 1
MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_s" [0 0 0] )" +
                        fog + R"(
Camera "perspective" "float fov" 20
WorldBegin
Shape "trianglemesh" "integer indices" [0 2 1 0 3 2] "point3 P" [-3 0 -3 3 0 -3 3 0 3 -3 0 3]
AttributeBegin
  Translate 2.5 1.5 0
  LightSource "point" "rgb I" [5 5 5]
  MediumInterface "fog" ""
  Material "interface"
  Shape "sphere" "float radius" 0.5
AttributeEnd
)");
    };
    transport::RenderSettings settings;
    settings.channels.list = {lpe_channel("shadowless", "unoccluded;C<RD>L")};
    const auto clear = render_of(lit("\"rgb sigma_a\" [0 0 0]"), settings),
               dim = render_of(lit("\"rgb sigma_a\" [1 2 4]"), settings);
    const double passed[] = {std::exp(-0.5), std::exp(-1.0), std::exp(-2.0)};
    for (const display::ChannelId id : {0, 1}) {
        const std::vector<double> a = clear.frame_buffer.resolve(id), b = dim.frame_buffer.resolve(id);
        for (std::size_t i = 0; i < a.size(); ++i) {
            REQUIRE(a[i] > 0);
            // The end of the segment inside the ball is accurate to some ulps of 2.5.
            CHECK(b[i] / a[i] == Approx(passed[i % 3]).epsilon(1e-5));
        }
    }
}

TEST_CASE("every strategy finds a light through fog with the same mean", "[render][media][statistical]") {
    const auto scene = scene_of(film + R"(
MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_a" [0.1 0.2 0.3] "rgb sigma_s" [0.9 0.6 0.3] "float g" 0.5
MediumInterface "fog"
LookAt 0 0 3  0 0 0  0 1 0
Camera "perspective" "float fov" 50
WorldBegin
Material "diffuse" "rgb reflectance" [0.8 0.8 0.8]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-2 -1 2 2 -1 2 2 -1 -2 -2 -1 -2]
AttributeBegin
  Translate 0 0.6 0
  AreaLightSource "diffuse" "rgb L" [6 6 6]
  Shape "sphere" "float radius" 0.4
AttributeEnd
)");
    transport::RenderSettings settings;
    settings.samples.per_pixel = 256;
    settings.paths.max_depth = 4;
    settings.channels.list = {lpe_channel("volume", "CV.*"), lpe_channel("direct", "CVL"),
                              lpe_channel("surface", "C<RD>.*")};
    std::vector<std::vector<Estimate>> found;
    for (const char* strategy : {"mis", "light", "scattering"}) {
        settings.paths.integrator = path_with(text_parameter("strategy", strategy));
        const auto output = render_of(scene, settings);
        found.emplace_back();
        for (display::ChannelId id = 0; id < 4; ++id) found.back().push_back(estimate(output, id));
        settings.samples.seed += 100;
    }
    for (std::size_t id = 0; id < 4; ++id) {
        CAPTURE(id, found[0][id].mean, found[1][id].mean, found[2][id].mean, found[0][id].error);
        CHECK(found[0][id].mean > 0.001);
        CHECK(deviation(found[0][id], found[1][id]) <= 4.5);
        CHECK(deviation(found[0][id], found[2][id]) <= 4.5);
    }
}

TEST_CASE("laws 1 to 3 hold in fog", "[render][media][law1][law2][law3]") {
    const auto scene = scene_of(foggy_room());
    transport::RenderSettings settings;
    settings.samples.per_pixel = 16;
    settings.machine.threads = 1;
    const auto alone = render_of(scene, settings);
    settings.machine.threads = 2;
    settings.channels.list = {lpe_channel("emissive", "C[<L.>O]-CB"), lpe_channel("background", "CB"),
                              lpe_channel("diffuse", "C<RD>.*"),      lpe_channel("subsurface", "C<TD>.*"),
                              lpe_channel("specular", "C<RS>.*"),     lpe_channel("transmissive", "C<TS>.*"),
                              lpe_channel("haze", "C<V.'haze'>.*"),   lpe_channel("juice", "C<V.'juice'>.*")};
    const auto output = render_of(scene, settings);
    const std::vector<double> beauty = output.frame_buffer.resolve(output.beauty);
    CHECK(beauty == alone.frame_buffer.resolve(alone.beauty));
    std::vector<double> sum(beauty.size());
    for (display::ChannelId id = 1; id <= 8; ++id) {
        const std::vector<double> layer = output.frame_buffer.resolve(id);
        for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += layer[i];
        if (id == 7) CHECK(estimate(output, id).mean > 0.01);
    }
    for (std::size_t i = 0; i < sum.size(); ++i) REQUIRE(sum[i] == Approx(beauty[i]).epsilon(1e-12).margin(1e-300));
}

TEST_CASE("without a beauty fewer paths are simulated in fog, and the channels keep their means",
          "[render][media][law4]") {
    const auto scene = scene_of(foggy_room());
    transport::RenderSettings settings;
    settings.samples.per_pixel = 64;
    settings.channels.list = {lpe_channel("direct", "C<RD>L"), lpe_channel("twice", "C<RD><RD>L"),
                              lpe_channel("volume", "CVL")};
    const auto full = render_of(scene, settings);
    settings.channels.beauty = false;
    const auto pruned = render_of(scene, settings);
    CHECK(pruned.statistics.scattering_rays * 2 < full.statistics.scattering_rays);
    CHECK(pruned.statistics.shadow_rays * 4 < full.statistics.shadow_rays * 3);
    for (display::ChannelId id = 0; id < 3; ++id) {
        const Estimate a = estimate(full, id + 1), b = estimate(pruned, id);
        CAPTURE(id, a.mean, b.mean, a.error);
        CHECK(b.mean > 0);
        // Most rays are equal: these errors are overestimates, and the difference is compared with them.
        CHECK(deviation(a, b) <= 4.5);
    }
}

namespace {

/// Records the rows of every batch.
class RowRecorder : public display::SampleSink {
  public:
    void accumulate(const display::SampleTable& table) override {
        const std::lock_guard lock(mutex_);
        for (int row = 0; row < table.row_count(); ++row) {
            const auto i = static_cast<std::size_t>(row);
            const bool extra = row >= table.camera_row_count();
            ++count[{extra, table.is_volume[i] != 0}];
            if (!table.is_volume[i]) continue;
            nearest = std::min(nearest, table.depth[i]);
            farthest = std::max(farthest, table.depth[i]);
            opacity += table.opacity[i].average();
        }
    }
    [[nodiscard]] std::size_t expected_bytes() const override { return 0; }
    std::map<std::pair<bool, bool>, std::uint64_t> count;  // (extra, volume)
    float nearest = 1e30f, farthest = 0;
    double opacity = 0;

  private:
    std::mutex mutex_;
};

}  // namespace

TEST_CASE("camera rays report where in a medium they end: WriteDistance at collisions, AddSample for absorption",
          "[render][media]") {
    const auto recorded = [](const std::string& medium, transport::RenderOutput& output) {
        RowRecorder recorder;
        transport::RenderSettings settings;
        settings.samples.per_pixel = 256;
        settings.before_rendering = [&](const transport::RenderPlan&, std::vector<display::SampleSink*>& sinks) {
            sinks.push_back(&recorder);
            return raylex::success();
        };
        output = render_of(scene_of(ball(medium)), settings);
        return std::tuple(recorder.count, recorder.nearest, recorder.farthest, recorder.opacity);
    };
    const double samples = 8 * 8 * 256;
    auto output = render_of(scene_of(ball("\"rgb sigma_a\" [0 0 0] \"rgb sigma_s\" [0 0 0]")));
    {
        auto [count, nearest, farthest, opacity] =
            recorded("\"rgb sigma_a\" [0.5 0.5 0.5] \"rgb sigma_s\" [0.5 0.5 0.5]", output);
        const double stopped = double(count[{false, true}]);
        const double expected = 1 - std::exp(-1.0);  // binomial, 4.5 standard errors
        CHECK(std::abs(stopped / samples - expected) <= 4.5 * std::sqrt(expected * (1 - expected) / samples));
        CHECK(opacity == stopped);
        CHECK(nearest < 0.01f);
        CHECK(farthest <= 1);
        CHECK(farthest > 0.99f);
        CHECK(count[{true, true}] == 0);
        double alpha = 0;
        for (const double a : output.frame_buffer.resolve_alpha()) alpha += a / 64;
        CHECK(alpha == Approx(stopped / samples).epsilon(1e-6));
    }
    {
        auto [count, nearest, farthest, opacity] = recorded("\"rgb sigma_a\" [1 1 1] \"rgb sigma_s\" [0 0 0]", output);
        CHECK(count[{false, true}] == 0);
        CHECK(double(count[{true, true}]) == samples);
        CHECK(opacity / samples == Approx(1 - std::exp(-1.0)).epsilon(1e-5));
        CHECK(nearest < 0.01f);
        CHECK(farthest <= 1);
    }
}

TEST_CASE("deep images store a medium as spans with Beer-Lambert transmittance at every depth", "[render][media]") {
    // Half scattering: collisions stop rays. Absorption only: extra samples have their share. Both must composite
    // alike.
    for (const char* medium : {"\"rgb sigma_a\" [0.5 0.5 0.5] \"rgb sigma_s\" [0.5 0.5 0.5]",
                               "\"rgb sigma_a\" [1 1 1] \"rgb sigma_s\" [0 0 0]"}) {
        std::unique_ptr<display::DeepBuffer> deep;
        transport::RenderSettings settings;
        settings.samples.per_pixel = 1024;
        settings.before_rendering = [&](const transport::RenderPlan& plan, std::vector<display::SampleSink*>& sinks) {
            display::DeepOptions options;
            options.tolerance = 0.25;
            deep = std::make_unique<display::DeepBuffer>(plan.width, plan.height, plan.channels,
                                                         std::vector<display::ChannelId>{plan.beauty}, options);
            sinks.push_back(deep.get());
            return raylex::success();
        };
        const auto output = render_of(scene_of(ball(medium)), settings);
        const std::vector<double> beauty = output.frame_buffer.resolve(output.beauty),
                                  alpha = output.frame_buffer.resolve_alpha();
        int spans = 0;
        double worst = 0;
        for (int p = 0; p < 64; ++p) {
            double through = 1, color = 0;
            for (const display::DeepSample& sample : deep->resolve(p % 8, p / 8)) {
                color += through * double(sample.values[0]);
                through *= 1 - double(sample.alpha);
                if (sample.z >= display::deep_background) continue;
                CHECK(sample.z_back <= 1);
                if (sample.z_back > sample.z) ++spans;
                // A span ends at a collision, so one ray of 1024 is always counted there. Near the camera too few have
                // collided for a normal distribution.
                if (sample.z_back < 0.05f) continue;
                const double expected = std::exp(-double(sample.z_back));
                const double off = std::max(std::abs(through - expected) - 1.0 / 1024, 0.0);
                worst = std::max(worst, off / std::sqrt(expected * (1 - expected) / 1024));
            }
            CHECK(1 - through == Approx(alpha[std::size_t(p)]).epsilon(1e-5));
            CHECK(color == Approx(beauty[std::size_t(3 * p)]).epsilon(1e-5));
        }
        CAPTURE(medium, spans, worst);
        CHECK(spans > 64 * 8);
        CHECK(worst <= 5.5);  // of about 1300 binomial numbers: exceeded by chance once in 20,000 runs
    }
}

TEST_CASE("a scene's alphabet contains the media in use and their emission", "[render][media]") {
    auto alphabet = transport::scene_alphabet(scene_of(foggy_room()));
    REQUIRE(alphabet.ok());
    const auto has = [](const std::vector<raylex::lpe::Event>& events, const raylex::lpe::Event& event) {
        return std::find(events.begin(), events.end(), event) != events.end();
    };
    CHECK(has(alphabet->scattering, transport::phase_event("haze")));
    CHECK(has(alphabet->scattering, transport::phase_event("juice")));
    CHECK(has(alphabet->terminals, transport::emission_event()));
    std::string unused = room;
    unused.replace(unused.find("LookAt"), 6, "MakeNamedMedium \"haze\" \"string type\" \"homogeneous\"\nLookAt");
    alphabet = transport::scene_alphabet(scene_of(unused));
    REQUIRE(alphabet.ok());
    CHECK_FALSE(has(alphabet->scattering, transport::phase_event("haze")));
    CHECK_FALSE(has(alphabet->terminals, transport::emission_event()));
}

namespace {

class BlindIntegrator final : public transport::Integrator {
  public:
    raylex::Status prepare(const transport::IntegratorContext&) override { return raylex::success(); }
    [[nodiscard]] std::unique_ptr<transport::IntegratorThread> make_thread_state() const override {
        return std::make_unique<transport::IntegratorThread>();
    }
    void integrate(const transport::CameraBatch&, transport::IntegratorThread&,
                   transport::ThreadServices&) const override {}
};

}  // namespace

TEST_CASE("an integrator without support for media is refused for scenes with media", "[render][media][law7]") {
    transport::integrator_registry().add(
        {"test-blind", "black", {}, [](const transport::SceneEntity&, std::optional<std::int64_t>) {
             return raylex::Result<std::unique_ptr<transport::Integrator>>(std::make_unique<BlindIntegrator>());
         }});
    transport::RenderSettings settings;
    settings.samples.per_pixel = 1;
    settings.paths.integrator.emplace().type = "test-blind";
    CHECK(transport::render(scene_of(room), settings).ok());
    auto refused = transport::render(scene_of(foggy_room()), settings);
    REQUIRE_FALSE(refused.ok());
    CHECK(refused.error().message.find("participating media") != std::string::npos);
}
