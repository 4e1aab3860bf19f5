// Renders whose paths never end react to a stop and to time limits, and their results can be continued.
#include "tests/transport/interrupted_render.h"

#include <chrono>
#include <thread>

using namespace render_test;

namespace {

/// The path integrator, except that it never returns from the batch with this sample of the pixel (0, 0), once.
class Stalling final : public transport::Integrator {
  public:
    Stalling(std::unique_ptr<transport::Integrator> path, std::uint64_t sample)
        : path_(std::move(path)), sample_(sample) {}
    [[nodiscard]] transport::IntegratorTraits traits() const override { return path_->traits(); }
    [[nodiscard]] transport::PlanRequest plan_request() const override { return path_->plan_request(); }
    raylex::Status prepare(const transport::IntegratorContext& context) override { return path_->prepare(context); }
    [[nodiscard]] std::unique_ptr<transport::IntegratorThread> make_thread_state() const override {
        return path_->make_thread_state();
    }
    void integrate(const transport::CameraBatch& batch, transport::IntegratorThread& thread,
                   transport::ThreadServices& services) const override {
        path_->integrate(batch, thread, services);
        for (const display::CameraRow& row : batch.rows)
            if (row.pixel_x == 0 && row.pixel_y == 0 && row.sample == sample_ && stalls.exchange(false)) {
                if (stop != nullptr) stop->store(true);
                while (!services.leaving()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
            }
    }
    static inline std::atomic<bool> stalls{false};
    static inline std::atomic<bool>* stop = nullptr;

  private:
    std::unique_ptr<transport::Integrator> path_;
    std::uint64_t sample_;
};

transport::SceneEntity stalling(std::uint64_t sample) {
    transport::SceneEntity entity;
    entity.type = "stalling at " + std::to_string(sample);
    if (transport::integrator_registry().find(entity.type) == nullptr)
        transport::integrator_registry().add(
            {entity.type,
             "for this test",
             {},
             [sample](const transport::SceneEntity&,
                      std::optional<std::int64_t> max_depth) -> raylex::Result<std::unique_ptr<transport::Integrator>> {
                 auto chosen = transport::choose_integrator({}, max_depth);
                 if (!chosen) return chosen.error();
                 return std::unique_ptr<transport::Integrator>(
                     std::make_unique<Stalling>(std::move(chosen->integrator), sample));
             }});
    return entity;
}

/// A medium from which no light escapes and in which none is absorbed.
const std::string endless = film + R"(
Integrator "path" "integer maxdepth" 1000000
LookAt 0 0 0  0 0 1  0 1 0
Camera "perspective" "float fov" 60
WorldBegin
LightSource "point" "rgb I" [1 1 1] "point3 from" [0 0.5 0]
Material "diffuse" "rgb reflectance" [1 1 1]
Shape "sphere" "float radius" 2
)";

struct Ended {
    transport::RenderOutput output;
    double seconds = 0;  ///< from the stop, or from the beginning without one
};
Ended render_endless(transport::RenderSettings settings, bool with_stop) {
    std::atomic<bool> stop{false};
    using Clock = std::chrono::steady_clock;
    Clock::time_point from = Clock::now();
    std::thread stopper([&] {
        if (!with_stop) return;
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
        from = Clock::now();
        stop.store(true);
    });
    settings.machine.threads = 2;
    auto output = transport::render(scene_of(endless), settings, {}, &stop);
    const Clock::time_point end = Clock::now();
    stopper.join();
    INFO((output ? std::string() : output.error().to_string()));
    REQUIRE(output.ok());
    return {*std::move(output), std::chrono::duration<double>(end - from).count()};
}

transport::SceneEntity without_roulette(const std::string& type) {
    transport::SceneEntity entity;
    entity.type = type;
    entity.parameters.parameters.push_back(flag_parameter("roulette", false));
    return entity;
}

/// The time that a busy machine may add to the second that a stop may take.
constexpr double busy = 1;

}  // namespace

TEST_CASE("Endless paths are left within a second of a stop", "[stopping]") {
    const std::string integrator = GENERATE("path", "lighttracer", "pssmlt");
    INFO(integrator);
    transport::RenderSettings settings;
    settings.paths.integrator = without_roulette(integrator);
    const Ended ended = render_endless(settings, true);
    CHECK_FALSE(ended.output.samples.complete);
    CHECK(ended.output.statistics.camera_samples == 0);
    CHECK(ended.seconds < 1 + busy);
}

TEST_CASE("Endless paths are left within a second of the time limit", "[stopping]") {
    transport::RenderSettings settings;
    settings.paths.integrator = without_roulette("path");
    settings.stop.limit = transport::SampleLimit{.seconds = 0.1};
    const Ended ended = render_endless(settings, false);
    CHECK_FALSE(ended.output.samples.complete);
    CHECK(ended.output.statistics.camera_samples == 0);
    CHECK(ended.seconds < 0.1 + 1 + busy);
}

TEST_CASE("A render that had to leave a batch continues to the same bits", "[law3][stopping][checkpoint]") {
    const transport::SceneDescription scene = scene_of(room);
    transport::RenderSettings settings;
    settings.machine.threads = 2;
    settings.samples.per_pixel = 96;
    settings.paths.integrator = stalling(37);
    const bool adaptive = GENERATE(false, true);
    INFO("adaptive " << adaptive);
    if (adaptive) {
        settings.stop.adaptive = display::AdaptiveSettings();
        settings.stop.adaptive->error = 0.05;
        settings.stop.adaptive->max_samples = 96;
    }
    Stalling::stalls = false;
    const transport::RenderOutput whole = render_of(scene, settings);

    const ScratchFile file;
    std::atomic<bool> stop{false};
    settings.checkpoint = transport::CheckpointSettings();
    settings.checkpoint->file = file.path();
    settings.checkpoint->seconds = 1e6;
    Stalling::stop = &stop;
    Stalling::stalls = true;
    auto first = transport::render(scene, settings, {}, &stop);
    Stalling::stop = nullptr;
    REQUIRE(first.ok());
    CHECK_FALSE(first->samples.complete);
    CHECK_FALSE(Stalling::stalls.load());
    REQUIRE(file.exists());

    settings.checkpoint->resume = true;
    const transport::RenderOutput resumed = render_of(scene, settings);
    CHECK(resumed.samples.complete);
    CHECK(resumed.samples.resumed == first->statistics.camera_samples);
    CHECK(resumed.frame_buffer.resolve(resumed.beauty) == whole.frame_buffer.resolve(whole.beauty));
    CHECK(resumed.statistics.camera_samples == whole.statistics.camera_samples);
    CHECK(resumed.statistics.camera_rays == whole.statistics.camera_rays);
    CHECK(resumed.statistics.scattering_rays == whole.statistics.scattering_rays);
    CHECK(resumed.statistics.path_length_histogram == whole.statistics.path_length_histogram);
}

TEST_CASE("A pass stopped by the time limit is undone, so that the reported samples give the same bits",
          "[law3][stopping][gate]") {
    const transport::SceneDescription scene = scene_of(room);
    transport::RenderSettings settings;
    settings.machine.threads = 2;
    settings.paths.integrator = stalling(37);
    settings.stop.limit = transport::SampleLimit{.seconds = 1.5};
    Stalling::stalls = true;
    const transport::RenderOutput limited = render_of(scene, settings);
    CHECK(limited.samples.complete);
    // Passes of 16 and 16 samples remain, and the third is undone.
    REQUIRE(limited.samples.per_pixel == 32);
    CHECK(limited.statistics.camera_samples == 24 * 24 * 32);
    Stalling::stalls = false;
    settings.stop.limit.reset();
    settings.samples.per_pixel = 32;
    const transport::RenderOutput asked = render_of(scene, settings);
    CHECK(limited.frame_buffer.resolve(limited.beauty) == asked.frame_buffer.resolve(asked.beauty));
    CHECK(limited.statistics.scattering_rays == asked.statistics.scattering_rays);
}

TEST_CASE("A first pass that is too long is started again with fewer samples", "[law3][stopping]") {
    const transport::SceneDescription scene = scene_of(room);
    transport::RenderSettings settings;
    settings.machine.threads = 2;
    settings.paths.integrator = stalling(7);  // once: the second attempt succeeds
    settings.stop.limit = transport::SampleLimit{.seconds = 1};
    Stalling::stalls = true;
    const transport::RenderOutput limited = render_of(scene, settings);
    CHECK(limited.samples.complete);
    CHECK(limited.samples.per_pixel >= 1);
    CHECK(limited.samples.per_pixel < 16);
    settings.samples.per_pixel = limited.samples.per_pixel;
    settings.stop.limit.reset();
    const transport::RenderOutput asked = render_of(scene, settings);
    CHECK(limited.frame_buffer.resolve(limited.beauty) == asked.frame_buffer.resolve(asked.beauty));
}

TEST_CASE("An integrator selected by name keeps the scene's depth", "[render]") {
    transport::SceneEntity scene, asked;
    scene.type = "volpath";
    Parameter depth;
    depth.name = "maxdepth";
    depth.type = ParameterType::integer;
    depth.numbers = {17};
    scene.parameters.parameters = {depth, flag_parameter("roulette", false), flag_parameter("nobody's", true)};
    asked.type = "lighttracer";
    const auto depth_of = [](const transport::SceneEntity& entity) {
        auto chosen = transport::choose_integrator(entity, {});
        REQUIRE(chosen.ok());
        CHECK(chosen->warnings.empty());
        return chosen->integrator->traits().max_depth;
    };
    CHECK(depth_of(transport::integrator_for(asked, scene)) == 17);
    CHECK(transport::integrator_for(asked, scene).parameters.parameters.size() == 2);
    CHECK(transport::integrator_for({}, scene).parameters.parameters.size() == 3);
    depth.numbers = {3};
    asked.parameters.parameters = {depth};
    CHECK(depth_of(transport::integrator_for(asked, scene)) == 3);
}
