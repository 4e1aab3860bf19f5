// A render that is interrupted and resumed has the same bits as one that is not (Law 3), or is refused by name.
#include <cerrno>

#include "display/output/atomic_file.h"
#include "tests/transport/interrupted_render.h"

using namespace render_test;

namespace {

/// Enough samples for a checkpoint to be due during the render.
#ifdef __SANITIZE_ADDRESS__
constexpr int samples_until_due = 400;  // each takes several times as long with the sanitizer
#else
constexpr int samples_until_due = 1500;
#endif

/// All data that must be equal: every plane of the frame buffer and of the mattes, and the sums of statistics.
std::string everything(const transport::RenderOutput& output) {
    std::string bytes;
    output.frame_buffer.append_record(bytes);
    for (const auto& matte : output.cryptomatte) matte.coverage().append_record(bytes);
    const transport::RenderStatistics& s = output.statistics;
    for (const std::uint64_t number : {s.camera_samples, s.camera_rays, s.scattering_rays, s.shadow_rays,
                                       s.invalid_samples, s.attribution_overflow, s.refused_services_calls})
        bytes += std::to_string(number) + " ";
    for (const std::uint64_t number : s.path_length_histogram) bytes += std::to_string(number) + " ";
    return bytes;
}

transport::RenderSettings room_settings() {
    transport::RenderSettings settings;
    settings.paths.integrator = counted("path");
    settings.samples.per_pixel = 200;  // the last block is incomplete
    settings.machine.threads = 2;
    settings.channels.list = {lpe_channel("direct", "CDL"),
                              lpe_channel("glossy", "C<.G>.*"),
                              aov("Nn"),
                              aov("id"),
                              aov("sampleCount"),
                              aov("z")};
    settings.mattes.kinds = {raylex::geoaovs::MatteKind::object, raylex::geoaovs::MatteKind::material};
    return settings;
}

/// Renders in sessions of at least `samples` more camera samples each, with 1, 2, 3, 1 ... threads.
transport::RenderOutput in_sessions(const transport::SceneDescription& scene, transport::RenderSettings settings,
                                    const ScratchFile& file, std::uint64_t samples, int& sessions) {
    settings.identity = {{"test", "1"}};
    settings.checkpoint = transport::CheckpointSettings{.file = file.path(), .seconds = 0.01};
    for (sessions = 1;; ++sessions) {
        std::atomic<bool> stop{false};
        settings.machine.threads = 1 + sessions % 3;
        interruption().begin(samples, &stop);
        auto output = transport::render(scene, settings, {}, &stop);
        interruption().begin(0, nullptr);
        INFO((output ? std::string() : output.error().to_string()));
        REQUIRE(output.ok());
        REQUIRE(sessions < 1000);
        if (output->samples.complete) return *std::move(output);
        REQUIRE(file.exists());
        settings.checkpoint->resume = true;
    }
}

/// The Error of resuming with these settings.
raylex::Error refusal(const transport::SceneDescription& scene, transport::RenderSettings settings,
                      const ScratchFile& file) {
    settings.identity = {{"test", "1"}};
    settings.checkpoint = transport::CheckpointSettings{.file = file.path(), .resume = true};
    auto output = transport::render(scene, settings);
    REQUIRE_FALSE(output.ok());
    return output.error();
}

}  // namespace

TEST_CASE("a render in many sessions has the bits of one that was never interrupted", "[render][checkpoint][law3]") {
    const auto scene = scene_of(room);
    transport::RenderSettings settings = room_settings();
    const auto whole = render_of(scene, settings);
    const ScratchFile file;
    int sessions = 0;
    const auto resumed = in_sessions(scene, settings, file, 12000, sessions);
    CHECK(sessions > 2);
    CHECK(resumed.samples.resumed > 0);
    CHECK(resumed.statistics.render_seconds > 0);
    CHECK((everything(resumed) == everything(whole)));
    CHECK(file.exists());  // the caller removes it when the image is written
}

TEST_CASE("adaptive sampling makes the same decisions after interruptions", "[render][checkpoint][adaptive][law3]") {
    const auto scene = scene_of(room);
    transport::RenderSettings settings = room_settings();
    settings.stop.adaptive.emplace();
    settings.stop.adaptive->error = 0.1;
    settings.stop.adaptive->max_samples = 500;
    const auto whole = render_of(scene, settings);
    CHECK(whole.statistics.camera_samples < 24 * 24 * 500);
    const ScratchFile file;
    int sessions = 0;
    const auto resumed = in_sessions(scene, settings, file, 12000, sessions);
    CHECK(sessions > 2);
    CHECK((everything(resumed) == everything(whole)));
    CHECK(resumed.samples.adaptive->error == whole.samples.adaptive->error);
    CHECK(resumed.samples.unconverged_pixels == whole.samples.unconverged_pixels);
}

TEST_CASE("checkpoints during a render change nothing", "[render][checkpoint][law3][gate]") {
    const auto scene = scene_of(room);
    transport::RenderSettings settings = room_settings();
    settings.samples.per_pixel = samples_until_due;
    const auto whole = render_of(scene, settings);
    const ScratchFile file;
    settings.checkpoint = transport::CheckpointSettings{.file = file.path(), .seconds = 0.01};
    const auto saved = render_of(scene, settings);
    CHECK(saved.statistics.checkpoints > 0);
    CHECK((everything(saved) == everything(whole)));
    // Another render resumes from the last of them, as after a kill.
    settings.checkpoint->resume = true;
    const auto resumed = render_of(scene, settings);
    CHECK(resumed.samples.resumed > 0);
    CHECK((everything(resumed) == everything(whole)));
}

TEST_CASE("a checkpoint of another render is refused, and the differences are named", "[render][checkpoint][law7]") {
    const auto scene = scene_of(room);
    transport::RenderSettings settings = room_settings();
    const ScratchFile file;
    CHECK(refusal(scene, settings, file).message.find("no checkpoint to resume from") != std::string::npos);
    int sessions = 0;
    in_sessions(scene, settings, file, 12000, sessions);
    const auto names = [&](const transport::RenderSettings& other, const std::string& difference) {
        const raylex::Error error = refusal(scene, other, file);
        CAPTURE(error.message, difference);
        CHECK(error.file == file.path());
        CHECK(error.message.find("the checkpoint belongs to another render") != std::string::npos);
        CHECK(error.message.find(difference) != std::string::npos);
    };
    transport::RenderSettings other = settings;
    other.samples.seed = 7;
    names(other, "seed: 0 there, 7 here");
    other = settings;
    other.samples.per_pixel = 300;
    names(other, "samples per pixel: 200 there, 300 here");
    other = settings;
    other.film.resolution = {{12, 12}};
    names(other, "resolution: 24x24 there, 12x12 here");
    other = settings;
    other.channels.list.pop_back();
    names(other, "channel z: z, ");
    other = settings;
    other.channels.list[0].expression = "CDDL";
    names(other, "channel direct: CDL, type 1, rule 0, statistics there, CDDL");
    other = settings;
    other.mattes.kinds.pop_back();
    names(other, "cryptomatte CryptoMaterial");
    other = settings;
    other.paths.max_depth = 2;
    names(other, "max depth: nothing there, 2 here");
    other = settings;
    other.labels.picked_lobes = true;
    names(other, "lobes: exact there, picked here");
    other = settings;
    other.film.filter.emplace();
    other.film.filter->type = "gaussian";
    names(other, "pixel filter: box there, gaussian gaussian() here");
    other = settings;
    other.machine.isa = "sse2";
    names(other, "instruction set: ");
    other = settings;
    other.stop.adaptive.emplace();
    names(other, "adaptive: nothing there, error 0.01 of beauty or all light, 64 to 65536 samples");

    std::string text = room;
    text.replace(text.find("0.7 0.6 0.5"), 3, "0.8");
    const raylex::Error error = refusal(scene_of(text), settings, file);
    CHECK(error.message.find("\n  scene: ") != std::string::npos);
    CHECK(error.message.find("seed") == std::string::npos);
}

TEST_CASE("a damaged checkpoint is refused and left as it is", "[render][checkpoint][law7]") {
    const auto scene = scene_of(room);
    transport::RenderSettings settings = room_settings();
    settings.film.resolution = {{8, 8}};
    const ScratchFile file;
    int sessions = 0;
    in_sessions(scene, settings, file, 2000, sessions);
    REQUIRE(file.exists());
    const std::string intact = file.bytes();
    for (const std::size_t size : {std::size_t{0}, std::size_t{17}, intact.size() / 2, intact.size() - 1}) {
        file.write(intact.substr(0, size));
        CHECK(refusal(scene, settings, file).message.find("cannot resume: the file is truncated") != std::string::npos);
        CHECK(file.bytes().size() == size);
    }
    std::string damaged = intact;
    damaged[intact.size() / 2] = static_cast<char>(damaged[intact.size() / 2] ^ 4);
    file.write(damaged);
    CHECK(refusal(scene, settings, file).message.find("section 'frame buffer' is damaged") != std::string::npos);
    CHECK((file.bytes() == damaged));
}

TEST_CASE("a checkpoint that cannot be written is a warning, and the render continues",
          "[render][checkpoint][law7][gate]") {
    const auto scene = scene_of(room);
    transport::RenderSettings settings = room_settings();
    settings.samples.per_pixel = samples_until_due;
    const auto whole = render_of(scene, settings);
    const ScratchFile file;
    settings.checkpoint = transport::CheckpointSettings{.file = file.path(), .seconds = 0.01};
    display::set_file_fault(
        [](display::FileCall call, const std::string&) { return call == display::FileCall::sync ? EIO : 0; });
    const auto output = render_of(scene, settings);
    display::set_file_fault(nullptr);
    CHECK((everything(output) == everything(whole)));
    CHECK(output.statistics.checkpoints == 0);
    REQUIRE_FALSE(output.warnings.empty());
    CHECK(output.warnings.back().file == file.path());
    CHECK(output.warnings.back().message.find("a checkpoint could not be saved: ") != std::string::npos);
    CHECK_FALSE(file.exists());
}

namespace {

/// Light that grows with the iterations, so its value depends on state that a checkpoint must restore.
class Counting final : public transport::Integrator {
  public:
    explicit Counting(transport::SavedState state) : state_(state) {}
    [[nodiscard]] transport::IntegratorTraits traits() const override {
        transport::IntegratorTraits traits;
        traits.saved_state = state_;
        return traits;
    }
    raylex::Status prepare(const transport::IntegratorContext&) override { return raylex::success(); }
    [[nodiscard]] std::unique_ptr<transport::IntegratorThread> make_thread_state() const override {
        return std::make_unique<transport::IntegratorThread>();
    }
    [[nodiscard]] bool synchronous() const override { return true; }
    void integrate(const transport::CameraBatch& batch, transport::IntegratorThread& thread,
                   transport::ThreadServices& services) const override {
        for (int row = 0; row < static_cast<int>(batch.rays.size()); ++row) {
            auto tracker = services.lpe.begin(row);
            services.lpe.contribute(raylex::Rgb(static_cast<float>(iterations_)), display::Technique{}, tracker);
        }
        thread.counters.camera_rays += batch.rays.size();
    }
    void end_iteration(std::uint64_t, std::span<transport::IntegratorThread* const>) override {
        iterations_ = iterations_ * 3 % 1009;
        interruption().count(1);  // within an iteration there is nothing to save
    }
    void save_state(std::string& bytes) const override { bytes += std::to_string(iterations_); }
    raylex::Status restore_state(std::string_view bytes) override {
        iterations_ = static_cast<std::uint64_t>(std::stoull(std::string(bytes)));
        return raylex::success();
    }

  private:
    transport::SavedState state_;
    std::uint64_t iterations_ = 1;
};

}  // namespace

TEST_CASE("an integrator's own state is saved, or the integrator is named and refused",
          "[render][checkpoint][law3][gate]") {
    for (const auto& [name, state] :
         {std::pair{"counting", transport::SavedState::saved}, std::pair{"silent", transport::SavedState::unknown}})
        transport::integrator_registry().add(
            {name,
             "for this test",
             {},
             [s = state](const transport::SceneEntity&,
                         std::optional<std::int64_t>) -> raylex::Result<std::unique_ptr<transport::Integrator>> {
                 return std::unique_ptr<transport::Integrator>(std::make_unique<Counting>(s));
             }});
    const auto scene = scene_of(room);
    transport::RenderSettings settings;
    settings.paths.integrator.emplace();
    settings.paths.integrator->type = "counting";
    settings.film.resolution = {{64, 64}};
    settings.samples.per_pixel = 1600;
    const auto whole = render_of(scene, settings);
    const ScratchFile file;
    int sessions = 0;
    const auto resumed = in_sessions(scene, settings, file, 30, sessions);
    CHECK(sessions > 1);
    CHECK((everything(resumed) == everything(whole)));

    settings.paths.integrator->type = "silent";
    settings.checkpoint = transport::CheckpointSettings{.file = file.path()};
    auto refused = transport::render(scene, settings);
    REQUIRE_FALSE(refused.ok());
    CHECK(refused.error().message.find("integrator 'silent' cannot save its state") != std::string::npos);
}

TEST_CASE("an interrupted render with an error limit continues to the same bits", "[law3][gate]") {
    const auto scene = scene_of(room);
    const ScratchFile file;
    transport::RenderSettings settings;
    settings.samples.per_pixel = 100'000;
    settings.machine.threads = 2;
    settings.stop.limit = transport::SampleLimit{.error = 0.05};
    const std::string whole = everything(render_of(scene, settings));
    settings.checkpoint = transport::CheckpointSettings{.file = file.path(), .seconds = 0.01};
    std::atomic<bool> stop{false};
    auto output = transport::render(
        scene, settings, [&](const transport::RenderProgress& now) { stop = now.samples_done > 24 * 24 * 64; }, &stop);
    REQUIRE(output.ok());
    REQUIRE_FALSE(output->samples.complete);
    settings.checkpoint->resume = true;
    settings.machine.threads = 1;
    output = transport::render(scene, settings);
    REQUIRE(output.ok());
    CHECK(output->samples.resumed > 0);
    CHECK((everything(*output) == whole));
}
