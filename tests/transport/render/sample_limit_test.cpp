// Renders that end by time or error, and shards: their bits are those of a render with the number of samples that they
// reached.
#include "tests/transport/render_support.h"

using namespace render_test;

namespace {

std::string record_of(const transport::RenderOutput& output) {
    std::string bytes;
    output.frame_buffer.append_record(bytes);
    return bytes;
}

transport::RenderSettings settings_with(std::uint64_t samples) {
    transport::RenderSettings settings;
    settings.samples.per_pixel = samples;
    settings.machine.threads = 2;
    settings.channels.list = {lpe_channel("direct", "CDL")};
    return settings;
}

/// Checks that a render with a limit equals the render with its number of samples, with another number of threads.
void check_replay(const transport::SceneDescription& scene, const transport::RenderOutput& output) {
    CHECK(output.samples.complete);
    CHECK(output.statistics.camera_samples == output.samples.per_pixel * 24 * 24);
    transport::RenderSettings again = settings_with(output.samples.per_pixel);
    again.machine.threads = 1;
    CHECK((record_of(render_of(scene, again)) == record_of(output)));
}

}  // namespace

TEST_CASE("a render with a time limit equals the render with the samples that it reached", "[law3]") {
    const auto scene = scene_of(room);
    for (const double seconds : {1e-9, 0.15}) {
        transport::RenderSettings settings = settings_with(1);
        settings.samples.per_pixel.reset();
        settings.stop.limit = transport::SampleLimit{.seconds = seconds};
        const auto output = render_of(scene, settings);
        if (seconds < 1e-6) CHECK(output.samples.per_pixel == 1);
        check_replay(scene, output);
    }
    // A pass that would take longer than the remaining time is shortened before it begins.
    transport::RenderSettings settings = settings_with(1 << 20);
    settings.stop.limit = transport::SampleLimit{.seconds = 1000, .seconds_per_sample = 300};
    CHECK(render_of(scene, settings).samples.per_pixel == 3);
}

TEST_CASE("any sample that a limited render can reach can be replayed at once, without a checkpoint") {
    const auto scene = scene_of(room);
    transport::RenderSettings settings = settings_with(1);
    settings.samples.per_pixel.reset();
    settings.stop.limit = transport::SampleLimit{.seconds = 1e-9};
    settings.checkpoint.emplace();
    settings.checkpoint->file = "no folder/of this name";
    settings.checkpoint->resume = true;
    settings.samples.only = transport::SampleChoice{.x = 5, .y = 7, .sample = 1'000'000};
    const auto output = render_of(scene, settings);
    CHECK(output.samples.complete);
    CHECK(output.statistics.camera_samples == 1);
    CHECK(output.statistics.checkpoints == 0);
    CHECK(output.frame_buffer.sample_count(5, 7) == 1);
}

TEST_CASE("a render with an error limit reaches the error, and one pass less would not") {
    const auto scene = scene_of(room);
    transport::RenderSettings settings = settings_with(100'000);
    settings.stop.limit = transport::SampleLimit{.error = 0.08};
    const auto output = render_of(scene, settings);
    REQUIRE(output.samples.adaptive);
    CHECK(output.samples.adaptive->error <= 0.08);
    CHECK(output.samples.per_pixel > 64);
    check_replay(scene, output);
    // The error is proportional to 1 / sqrt(samples), and passes grow by an eighth: the excess is less than a quarter.
    CHECK(output.samples.adaptive->error > 0.08 / 1.25);

    settings.film.splat = true;
    CHECK_FALSE(transport::render(scene, settings).ok());
}

TEST_CASE("aligned shards merge to the bits of the whole, in any order", "[law3]") {
    const auto scene = scene_of(room);
    const auto whole = render_of(scene, settings_with(100));
    std::vector<transport::RenderOutput> shards;
    for (const auto& [first, end] : {std::pair(80, 100), std::pair(0, 32), std::pair(32, 80)}) {
        transport::RenderSettings settings = settings_with(static_cast<std::uint64_t>(end));
        settings.samples.first = static_cast<std::uint64_t>(first);
        shards.push_back(render_of(scene, settings));
    }
    REQUIRE(shards[0].frame_buffer.merge(shards[1].frame_buffer).ok());
    REQUIRE(shards[2].frame_buffer.merge(shards[0].frame_buffer).ok());
    CHECK((record_of(shards[2]) == record_of(whole)));

    transport::RenderSettings settings = settings_with(100);
    settings.samples.first = 8;
    auto refused = transport::render(scene, settings);
    REQUIRE_FALSE(refused.ok());
    CHECK(refused.error().message.find("expected a multiple of 16 below 100") != std::string::npos);
}
