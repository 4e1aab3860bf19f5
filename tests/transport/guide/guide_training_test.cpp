// How long the training of a guide is, and how it ends.
#include <stdexcept>

#include "transport/enclosure.h"
#include "transport/guide/guide_support.h"
#include "transport/render/stages/prepared_job.h"

using namespace render_test;

namespace {

/// An integrator whose guide cannot be trained.
class Unteachable final : public transport::Integrator {
  public:
    [[nodiscard]] transport::GuideRequest guide_request() const override {
        return {transport::GuideMode::on, 4, false, [] { return std::make_unique<Unteachable>(); }};
    }
    raylex::Status prepare(const transport::IntegratorContext& /*context*/) override { return raylex::success(); }
    void integrate(const transport::CameraBatch& /*batch*/, transport::IntegratorThread& /*thread*/,
                   transport::ThreadServices& /*services*/) const override {
        throw std::runtime_error("it learns nothing");
    }
};

}  // namespace

TEST_CASE("a render that ends by its error trains like a short one", "[guide][render]") {
    transport::RenderSettings settings = guided_settings(0, 1);
    settings.samples.per_pixel.reset();
    settings.stop.limit = transport::SampleLimit{.error = 0.5};
    const auto scene = scene_of(room);
    const auto output = render_of(scene, settings);
    CHECK(output.statistics.guide.samples == 16);  // a quarter of the fewest samples of such a render
    CHECK(output.samples.per_pixel == 64);
    settings.paths.integrator = with_guide(integrator_named("path"), "auto", 0);
    CHECK(render_of(scene, settings).statistics.guide.samples == 0);
}

TEST_CASE("auto waits for a forecast where light is rare", "[guide][render]") {
    const auto trained = [](const std::string& text) {
        const auto scene = transport::BuiltScene::build(scene_of(text));
        REQUIRE(scene.ok());
        transport::RenderSettings settings = guided_settings(0, 512);
        settings.paths.integrator = with_guide(integrator_named("path"), "auto", 0);
        auto job = transport::ResolvedJob::resolve(**scene, settings);
        REQUIRE(job.ok());
        auto prepared = transport::PreparedJob::prepare(*std::move(job));
        REQUIRE(prepared.ok());
        return prepared->guide.summary;
    };
    CHECK(trained(lamp_in_globe(0.3, 0.12, 60)).samples >= 64);  // half of the training
    const transport::GuideSummary common = trained(enclosure(0.5, 0.3));
    CHECK(common.samples == 8);
    CHECK_FALSE(common.used);
}

TEST_CASE("one sample of a render with a time limit needs the guide of the render", "[guide][render][law3]") {
    const auto scene = scene_of(room);
    const ScratchFile file;
    transport::RenderSettings settings = guided_settings(0, 1);
    settings.samples.per_pixel.reset();
    settings.stop.limit = transport::SampleLimit{.seconds = 4};  // also a sanitized build trains within half of it
    for (const std::string& path : {std::string(), file.path()}) {
        settings.paths.guide_file = path;
        settings.samples.only = transport::SampleChoice{1, 1, 1};
        const auto refused = transport::render(scene, settings);
        REQUIRE_FALSE(refused.ok());
        CHECK(refused.error().to_string().find("guidesamples") != std::string::npos);
    }
    settings.samples.only.reset();
    const std::uint32_t samples = render_of(scene, settings).statistics.guide.repeated();
    REQUIRE(samples > 0);
    settings.samples.only = transport::SampleChoice{1, 1, 1};
    const auto by_file = render_of(scene, settings);
    CHECK(by_file.statistics.guide.read);
    settings.paths.guide_file.clear();
    settings.paths.guide_samples = samples;
    CHECK((frame_bits(render_of(scene, settings)) == frame_bits(by_file)));
}

TEST_CASE("an exception in the training of a guide is the error of the render", "[guide][render]") {
    transport::integrator_registry().add(
        {"unteachable",
         "for this test",
         {},
         [](const auto&, auto) -> raylex::Result<std::unique_ptr<transport::Integrator>> {
             return std::unique_ptr<transport::Integrator>(std::make_unique<Unteachable>());
         }});
    transport::RenderSettings settings = guided_settings(0, 16);
    settings.paths.integrator = integrator_named("unteachable");
    const auto output = transport::render(scene_of(room), settings);
    REQUIRE_FALSE(output.ok());
    CHECK(output.error().to_string().find("the training of the guide failed: it learns nothing") != std::string::npos);
}
