// Law 6 in whole renders: the contributions of a light beyond float are rejected, and every rejection can be replayed.
#include "transport/render_support.h"

using namespace render_test;

namespace {

display::ChannelDefinition invalid_aov(const std::string& name) {
    display::ChannelDefinition channel;
    channel.name = name;
    return channel;
}

/// A nearly black quad under a light whose radiance is beyond float there, so every hit of a camera ray is rejected.
/// The frame buffer can sum all floats, so emission alone is not rejected.
transport::SceneDescription broken_scene() {
    return scene_of(film + R"(
Integrator "path" "integer maxdepth" 1
LookAt 0 0 4  0 0 0  0 1 0
Camera "perspective" "float fov" 39
WorldBegin
LightSource "infinite" "rgb L" [1e20 1e20 1e20]
LightSource "point" "rgb I" [3e38 3e38 3e38] "point3 from" [-0.08 0.13 0.05]
Material "diffuse" "rgb reflectance" [1e-7 1e-7 1e-7]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-0.53 -0.31 0 0.37 -0.31 0 0.37 0.57 0 -0.53 0.57 0]
)");
}

transport::RenderOutput render_broken(const transport::SceneDescription& scene,
                                      const transport::RenderSettings& settings) {
    auto output = transport::render(scene, settings);
    REQUIRE(output.ok());
    return *std::move(output);
}

}  // namespace

TEST_CASE("rejected contributions are counted at their own pixels, for any number of threads", "[render][law3][law6]") {
    const auto scene = broken_scene();
    transport::RenderSettings settings;
    settings.samples.per_pixel = 20;  // a whole block and a partial one
    settings.channels.list = {lpe_channel("lit", "C<RD>L"), lpe_channel("sky", "CB"), invalid_aov("invalidSamples"),
                              invalid_aov("a")};
    settings.machine.threads = 1;
    const auto one = render_broken(scene, settings);
    settings.machine.threads = 3;
    const auto three = render_broken(scene, settings);
    const std::vector<double> counts = one.frame_buffer.resolve(3), alpha = one.frame_buffer.resolve(4),
                              light = one.frame_buffer.resolve(0);
    CHECK(three.frame_buffer.resolve(3) == counts);
    double total = 0;
    int partial = 0;
    for (std::size_t i = 0; i < counts.size(); ++i) {
        // Box filter: alpha is the share of the 20 samples that hit the quad, and each of these is rejected once.
        CHECK(counts[i] == Approx(20 * alpha[i]).margin(1e-9));
        CHECK(light[3 * i] == Approx(1e20 * (1 - alpha[i])).margin(1e14));  // the quad scatters 1e-7 of the sky
        partial += counts[i] > 0 && counts[i] < 20 ? 1 : 0;
        total += counts[i];
    }
    CHECK(total > 500);
    CHECK(partial > 10);
    for (const auto* output : {&one, &three}) {
        CHECK(static_cast<double>(output->statistics.invalid_samples) == total);
        CHECK(static_cast<double>(output->statistics.invalid_by_channel[0]) == total);
        CHECK(static_cast<double>(output->statistics.invalid_by_channel[1]) == total);
        CHECK(output->statistics.invalid_by_channel[2] == 0);
    }
    // The log is equal too, and a render of each logged sample alone reproduces its entry.
    REQUIRE(one.statistics.invalid_log.size() == display::SampleTable::invalid_samples_kept);
    REQUIRE(three.statistics.invalid_log.size() == one.statistics.invalid_log.size());
    for (std::size_t i = 0; i < one.statistics.invalid_log.size(); ++i) {
        const display::InvalidSample &a = one.statistics.invalid_log[i], &b = three.statistics.invalid_log[i];
        CHECK((a.pixel_x == b.pixel_x && a.pixel_y == b.pixel_y && a.sample == b.sample));
        settings.samples.only = transport::SampleChoice{.x = a.pixel_x, .y = a.pixel_y, .sample = a.sample};
        const auto again = render_broken(scene, settings);
        CHECK(again.statistics.camera_samples == 1);
        REQUIRE(again.statistics.invalid_log.size() == 1);
        CHECK(again.statistics.invalid_log[0].value == a.value);
    }
    settings.samples.only = transport::SampleChoice{.x = 24};
    CHECK_FALSE(transport::render(scene, settings).ok());
    settings.samples.only = transport::SampleChoice{.sample = 20};
    CHECK_FALSE(transport::render(scene, settings).ok());
}
