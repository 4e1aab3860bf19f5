// Adaptive sampling in whole renders: the distribution of samples, invariants, and the bias.
#include <cstdio>

#include "tests/transport/render_support.h"

using namespace render_test;

namespace {

transport::RenderSettings adaptive_settings(double error, std::uint64_t most = 4096) {
    transport::RenderSettings settings;
    settings.machine.threads = 1;
    settings.stop.adaptive.emplace();
    settings.stop.adaptive->error = error;
    settings.stop.adaptive->max_samples = most;
    return settings;
}

display::ChannelDefinition sample_count() {
    display::ChannelDefinition channel;
    channel.name = "sampleCount";
    return channel;
}

double image_mean(const transport::RenderOutput& output) {
    double sum = 0;
    const std::vector<double> values = output.frame_buffer.resolve(output.beauty);
    for (const double value : values) sum += value;
    return sum / static_cast<double>(values.size());
}

}  // namespace

TEST_CASE("every pixel ends within the tolerance or with the most samples", "[render][adaptive]") {
    auto scene = scene_of(room);
    transport::RenderSettings settings = adaptive_settings(0.08, 1000);
    settings.channels.list = {sample_count()};
    const auto output = render_of(scene, settings);
    const display::FrameBuffer& buffer = output.frame_buffer;
    const std::vector<double> values = buffer.resolve(output.beauty),
                              variances = buffer.resolve_variance_of_mean(output.beauty), counts = buffer.resolve(1);
    double mean = 0;
    for (const double value : values) mean += value / static_cast<double>(values.size());
    std::uint64_t fewest = ~std::uint64_t{0}, most = 0, total = 0, above = 0;
    for (std::size_t pixel = 0; pixel < counts.size(); ++pixel) {
        const std::uint64_t samples = buffer.sample_count(static_cast<int>(pixel % 24), static_cast<int>(pixel / 24));
        // The AOV contains the true count.
        CHECK(counts[pixel] == static_cast<double>(samples));
        const double deviation =
            std::sqrt((variances[3 * pixel] + variances[3 * pixel + 1] + variances[3 * pixel + 2]) / 3);
        const double value = (values[3 * pixel] + values[3 * pixel + 1] + values[3 * pixel + 2]) / 3;
        if (deviation > 0.08 * std::max(value, 0.1 * mean)) {
            CHECK(samples == 1000);
            ++above;
        }
        CHECK(samples >= 64);
        fewest = std::min(fewest, samples);
        most = std::max(most, samples);
        total += samples;
    }
    CHECK(fewest < most);
    CHECK(total == output.statistics.camera_samples);
    REQUIRE(output.samples.adaptive.has_value());
    CHECK(output.samples.adaptive->open_pixels == 0);
    CHECK(output.samples.unconverged_pixels == above);
    CHECK(output.samples.complete);
}

TEST_CASE("channels outside the metric do not change an adaptive beauty", "[render][adaptive][law2][gate]") {
    auto scene = scene_of(room);
    transport::RenderSettings settings = adaptive_settings(0.15);
    const auto alone = render_of(scene, settings);
    settings.channels.list = {lpe_channel("direct", "CDL"), lpe_channel("glossy", "C<.G>.*"), sample_count()};
    const auto asked = render_of(scene, settings);
    CHECK((alone.frame_buffer.resolve(alone.beauty) == asked.frame_buffer.resolve(asked.beauty)));
    CHECK(alone.statistics.camera_samples == asked.statistics.camera_samples);
    // A channel in the metric makes a different job with other samples.
    settings.stop.adaptive->channels = {{"beauty", 1, {}}, {"direct", 3, {}}};
    const auto other = render_of(scene, settings);
    CHECK(other.statistics.camera_samples > asked.statistics.camera_samples);
}

TEST_CASE("without a beauty the metric uses all requested light", "[render][adaptive][law4][gate]") {
    auto scene = scene_of(room);
    transport::RenderSettings settings = adaptive_settings(0.15);
    settings.channels.beauty = false;
    settings.channels.list = {lpe_channel("direct", "CDL"), lpe_channel("glossy", "C<.G>.*"), sample_count()};
    const auto all = render_of(scene, settings);
    settings.stop.adaptive->channels = {{"direct", 1, {}}, {"glossy", 1, {}}};
    const auto named = render_of(scene, settings);
    CHECK(all.statistics.camera_samples == named.statistics.camera_samples);
    CHECK((all.frame_buffer.resolve(0) == named.frame_buffer.resolve(0)));
    settings.stop.adaptive->channels = {{"direct", 1, {}}};
    CHECK(render_of(scene, settings).statistics.camera_samples < all.statistics.camera_samples);
    settings.stop.adaptive->channels.clear();
    settings.channels.list = {sample_count()};
    CHECK_FALSE(transport::render(scene, settings).ok());  // no light has an error
}

TEST_CASE("any number of threads makes the same decisions", "[render][adaptive][law3]") {
    auto scene = scene_of(room);
    transport::RenderSettings settings = adaptive_settings(0.15);
    settings.channels.list = {lpe_channel("direct", "CDL")};
    std::string one, three;
    render_of(scene, settings).frame_buffer.append_record(one);
    settings.machine.threads = 3;
    render_of(scene, settings).frame_buffer.append_record(three);
    CHECK((one == three));
}

TEST_CASE("the predicted number of samples is close to the final one", "[render][adaptive][release-only][gate]") {
    auto scene = scene_of(room);
    transport::RenderSettings settings = adaptive_settings(0.04, 65536);
    settings.film.resolution = {{48, 48}};
    settings.machine.threads = 2;
    std::uint64_t first = 0;
    auto output = transport::render(scene, settings, [&](const transport::RenderProgress& now) {
        if (first == 0 && now.adaptive != nullptr && !now.adaptive->channel.empty()) first = now.samples_total;
    });
    REQUIRE(output.ok());
    REQUIRE(first > 0);
    const double ratio = static_cast<double>(output->statistics.camera_samples) / static_cast<double>(first);
    // The first prediction uses variances of 64 samples a pixel. Each is known to a quarter at best where light is
    // rare, and one-sidedly so; their sum over 2304 pixels is known better. Pixels reach the tolerance at a block's
    // end, up to a tenth late. A later prediction, if the first progress report comes late, is closer.
    CAPTURE(ratio);
    CHECK(ratio > 0.8);
    CHECK(ratio < 1.25);
}

TEST_CASE("invalid metrics are refused before rendering", "[render][adaptive][law7]") {
    auto scene = scene_of(room);
    transport::RenderSettings settings = adaptive_settings(0.1);
    settings.stop.adaptive->channels = {{"directt", 1, {}}};
    settings.channels.list = {lpe_channel("direct", "CDL")};
    auto output = transport::render(scene, settings);
    REQUIRE_FALSE(output.ok());
    CHECK(output.error().hint == "did you mean 'direct'?");
}

namespace {

/// The results of adaptive renders with many seeds, compared with a plain one of many samples. All use the independent
/// sampler.
struct Findings {
    Estimate bias;                 // of the image's mean, relative, with its standard error
    double samples_per_pixel = 0;  // in the mean
    double strays = 0;             // share of pixels that are wrong by more than three times the tolerance
};
Findings findings(int neighbourhood, std::uint64_t least, double error, int seeds) {
    auto scene = scene_of(room);
    auto built = transport::BuiltScene::build(scene);
    REQUIRE(built.ok());
    transport::RenderSettings settings;
    settings.samples.per_pixel = 16384;
    settings.samples.seed = 1000003;  // independent of the adaptive ones
    auto plain = transport::render(**built, settings);
    REQUIRE(plain.ok());
    const double reference = image_mean(*plain);
    // The error of the mean over pixels and colours; colours of a pixel are correlated, so their deviations add.
    const std::vector<double> variances = plain->frame_buffer.resolve_variance_of_mean(plain->beauty);
    double reference_variance = 0;
    for (std::size_t i = 0; i < variances.size(); i += 3) {
        const double deviation =
            (std::sqrt(variances[i]) + std::sqrt(variances[i + 1]) + std::sqrt(variances[i + 2])) / 3;
        reference_variance += deviation * deviation;
    }
    const double pixels = static_cast<double>(variances.size()) / 3;
    reference_variance /= pixels * pixels;

    settings = adaptive_settings(error, 65536);
    settings.machine.threads = 0;
    settings.stop.adaptive->neighbourhood = neighbourhood;
    settings.stop.adaptive->min_samples = least;
    const std::vector<double> truth = plain->frame_buffer.resolve(plain->beauty);
    Findings result;
    double sum = 0, square = 0;
    for (int seed = 0; seed < seeds; ++seed) {
        settings.samples.seed = static_cast<std::uint64_t>(seed);
        auto adaptive = transport::render(**built, settings);
        REQUIRE(adaptive.ok());
        const double mean = image_mean(*adaptive) / reference - 1;
        sum += mean;
        square += mean * mean;
        result.samples_per_pixel += static_cast<double>(adaptive->statistics.camera_samples) / (pixels * seeds);
        const std::vector<double> values = adaptive->frame_buffer.resolve(adaptive->beauty);
        for (std::size_t i = 0; i < values.size(); i += 3) {
            const double value = (truth[i] + truth[i + 1] + truth[i + 2]) / 3;
            const double wrong = std::abs((values[i] + values[i + 1] + values[i + 2]) / 3 - value);
            result.strays += wrong > 3 * error * std::max(value, 0.1 * reference) ? 1 / (pixels * seeds) : 0;
        }
    }
    const double mean = sum / seeds, variance = (square / seeds - mean * mean) / (seeds - 1);
    result.bias = {mean, std::sqrt(variance + reference_variance / (reference * reference))};
    return result;
}

}  // namespace

TEST_CASE("the bias of adaptive sampling is below the stated limit", "[render][adaptive][statistical][gate]") {
    const Findings found = findings(1, 64, 0.1, 60);
    CAPTURE(found.bias.mean, found.bias.error, found.samples_per_pixel, found.strays);
    // display/README.md states at most 0.5 %; four standard errors are exceeded by chance once in 16,000 runs.
    CHECK(std::abs(found.bias.mean) < 0.005 + 4 * found.bias.error);
    // The test must be sharp: the interval is narrower than the stated limit.
    CHECK(4 * found.bias.error < 0.005);
}

TEST_CASE("the effect of the neighbourhood on adaptive sampling", "[render][adaptive][.full][.measure]") {
    for (const std::uint64_t least : {std::uint64_t{64}, std::uint64_t{16}})
        for (const int neighbourhood : {0, 1, 2}) {
            const Findings found = findings(neighbourhood, least, 0.1, 100);
            std::printf(
                "at least %d samples, neighbourhood %d: %.0f samples per pixel, bias %+.2f %% +- %.2f %% (standard "
                "error), %.3f %% of pixels wrong by more than 30 %%\n",
                static_cast<int>(least), neighbourhood, found.samples_per_pixel, 100 * found.bias.mean,
                100 * found.bias.error, 100 * found.strays);
            CHECK(std::abs(found.bias.mean) < 0.005 + 4 * found.bias.error);
        }
}
