// The adaptive sampler's decisions, compared with an independent implementation of its formula.
#include "display/buffer/adaptive/adaptive_sampler.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <functional>

#include "display/services/samples/display_services.h"
#include "tests/services/helpers.h"

namespace raylex::display {
namespace {

constexpr int width = 8, height = 4;

std::vector<ChannelDefinition> two_channels() {
    std::vector<ChannelDefinition> channels{test::expression_channel("beauty", "C.*"),
                                            test::expression_channel("direct", "CDL"),
                                            test::plain_channel("z", ChannelType::real, FilterRule::zmin)};
    channels[0].statistics = channels[1].statistics = true;
    return channels;
}

/// A frame buffer with `blocks` blocks of 16 samples per pixel, with the values value(pixel, sample).
FrameBuffer sampled(int blocks, const std::function<double(int, int)>& value) {
    const auto channels = two_channels();
    FrameBuffer buffer({width, height}, channels);
    SampleTable table(channels, 16);
    DisplayServices services(table);
    for (int pixel = 0; pixel < width * height; ++pixel)
        for (int block = 0; block < blocks; ++block) {
            table.begin(test::pixel_rows(pixel % width, pixel / width, static_cast<std::uint64_t>(block * 16), 16));
            for (int row = 0; row < 16; ++row) {
                const double v = value(pixel, 16 * block + row);
                services.splat(0, row, Rgb(static_cast<float>(v)));
                services.splat(1, row, Rgb(static_cast<float>(2 * v)));
            }
            buffer.accumulate(table);
        }
    return buffer;
}

/// Samples alternate between value(pixel) + spread(pixel) and value(pixel) - spread(pixel), so the variance is known.
FrameBuffer flickering(int blocks, const std::function<double(int)>& value, const std::function<double(int)>& spread) {
    return sampled(blocks, [&](int pixel, int sample) {
        return value(pixel) + (sample % 2 == 0 ? spread(pixel) : -spread(pixel));
    });
}

AdaptiveSettings settings_with(double error, int neighbourhood) {
    AdaptiveSettings settings;
    settings.error = error;
    settings.neighbourhood = neighbourhood;
    settings.min_samples = 16;
    settings.max_samples = 1024;
    return settings;
}

int open_count(const AdaptiveSampler& sampler) {
    int count = 0;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) count += sampler.open(x, y) ? 1 : 0;
    return count;
}

/// For n samples that alternate between v + d and v - d: sample variance n d^2 / (n - 1), of the mean d^2 / (n - 1).
double deviation_of_mean(double d, int n) {
    return d / std::sqrt(n - 1.0);
}

}  // namespace

TEST_CASE("the error of a pixel is its standard error over its value or the floor", "[adaptive]") {
    const auto value = [](int pixel) { return pixel == 0 ? 0.0 : 1.0 + pixel; };
    const auto spread = [](int pixel) { return pixel == 5 ? 0.5 : 0.125; };
    const FrameBuffer buffer = flickering(2, value, spread);
    double mean = 0;
    for (int pixel = 0; pixel < width * height; ++pixel) mean += value(pixel) / (width * height);
    AdaptiveSampler sampler(settings_with(0.012, 0), two_channels(), 0, buffer.layout());
    CHECK(sampler.errors().empty());
    sampler.decide(buffer);
    double mean_square = 0;
    for (int pixel = 0; pixel < width * height; ++pixel) {
        const double expected = deviation_of_mean(spread(pixel), 32) / std::max(value(pixel), 0.1 * mean);
        CAPTURE(pixel);
        // The values are exact; roots and quotients of doubles round a few times each.
        CHECK(sampler.errors()[static_cast<std::size_t>(pixel)] == Approx(expected).epsilon(1e-12));
        CHECK(sampler.open(pixel % width, pixel / width) == (expected > 0.012));
        mean_square += expected * expected / (width * height);
    }
    CHECK(sampler.progress().error == Approx(std::sqrt(mean_square)).epsilon(1e-12));
    CHECK(sampler.progress().channel == "beauty");
    CHECK(sampler.progress().open_pixels == static_cast<std::uint64_t>(open_count(sampler)));
}

TEST_CASE("a neighbour's error keeps a pixel open until max_samples", "[adaptive]") {
    const auto one = [](int) { return 1.0; };
    const auto corner = [](int pixel) { return pixel == 2 * width + 4 ? 1.0 : 0.0; };
    const FrameBuffer buffer = flickering(1, one, corner);
    for (const auto& [radius, expected] : {std::pair{0, 1}, std::pair{1, 9}, std::pair{2, 20}}) {
        AdaptiveSampler sampler(settings_with(0.1, radius), two_channels(), 0, buffer.layout());
        sampler.decide(buffer);
        CHECK(open_count(sampler) == expected);
        CHECK(sampler.open(4, 2));
    }
    AdaptiveSettings settings = settings_with(0.1, 1);
    settings.max_samples = 16;
    AdaptiveSampler spent(settings, two_channels(), 0, buffer.layout());
    spent.decide(buffer);
    CHECK(spent.done());
    CHECK(spent.unconverged() == 1);
    settings = settings_with(0.1, 1);
    settings.min_samples = 17;
    AdaptiveSampler young(settings, two_channels(), 0, buffer.layout());
    CHECK(young.blocks() == 2);
    young.decide(buffer);
    CHECK(open_count(young) == width * height);
}

TEST_CASE("the metric takes the worst of its weighted channels", "[adaptive]") {
    const FrameBuffer buffer = flickering(
        2, [](int) { return 1.0; }, [](int) { return 0.25; });
    const double error = deviation_of_mean(0.25, 32);
    AdaptiveSettings settings = settings_with(0.1, 0);
    settings.channels = {{"beauty", 1, {}}, {"direct", 3, {}}};
    AdaptiveSampler sampler(settings, two_channels(), 0, buffer.layout());
    sampler.decide(buffer);
    CHECK(sampler.progress().channel == "direct");
    CHECK(sampler.progress().error == Approx(3 * error).epsilon(1e-12));
    CHECK(sampler.errors()[0] == Approx(3 * error).epsilon(1e-12));
}

TEST_CASE("the prediction assumes that errors fall with the root of the samples", "[adaptive]") {
    const FrameBuffer buffer = flickering(
        4, [](int) { return 1.0; }, [](int) { return 0.8; });
    const double error = deviation_of_mean(0.8, 64);
    AdaptiveSampler sampler(settings_with(error / 3, 0), two_channels(), 0, buffer.layout());
    sampler.decide(buffer);
    // A third of the error needs nine times the samples. 1 allows for rounding down to whole samples.
    CHECK(std::abs(static_cast<double>(sampler.progress().predicted_samples) - 9.0 * 64 * width * height) <= 1);
    AdaptiveSampler capped(settings_with(error / 30, 0), two_channels(), 0, buffer.layout());
    capped.decide(buffer);
    CHECK(capped.progress().predicted_samples == 1024 * width * height);
    AdaptiveSampler finished(settings_with(2 * error, 0), two_channels(), 0, buffer.layout());
    finished.decide(buffer);
    CHECK(finished.done());
    CHECK(finished.progress().predicted_samples == 64 * width * height);
}

TEST_CASE("the prediction includes samples that most pixels have not found yet", "[adaptive]") {
    // One pixel of four has found a sample that makes it five times as bright: of 64 samples the others are 1, so the
    // variance of its mean is the square of the increase. All pixels have such a neighbour.
    const FrameBuffer buffer = sampled(4, [](int pixel, int sample) {
        return sample == 0 && pixel % 2 == 0 && pixel / width % 2 == 0 ? 1.0 + 64 * 4 : 1.0;
    });
    AdaptiveSampler sampler(settings_with(0.5, 1), two_channels(), 0, buffer.layout());
    sampler.decide(buffer);
    CHECK(open_count(sampler) == width * height);
    // Four pixels pooled, and sixteen: an increase of 1 on a mean of 1. By the scatter of the pixels' variances the
    // relative deviation of that square is 1 and sqrt(0.2); the expected maximum of nine is 1.485 deviations above the
    // mean.
    const double four = 0.25 * (1 + 1.485), sixteen = 0.25 / 4 * (1 + 1.485 * std::sqrt(0.2));
    const double needed = 256 * std::pow(4, std::log(four / 0.25) / std::log(four / sixteen));
    const AdaptiveProgress& progress = sampler.progress();
    // 1 allows for rounding down to whole samples.
    CHECK(std::abs(static_cast<double>(progress.predicted_samples) - needed * width * height) <= 1);
    // The image is a single part, so its parts do not show the uncertainty.
    CHECK(std::abs(static_cast<double>(progress.least_samples) - needed * width * height * std::exp(-1)) <= 1);
    // The errors alone would give 2.56 times the current samples: the bright pixels' error is 4 / 5.
    CHECK(needed > 2 * samples_to_error(64, 0.8, 0.5));
}

TEST_CASE("a black image converges, with or without a floor", "[adaptive]") {
    const FrameBuffer buffer = flickering(
        1, [](int) { return 0.0; }, [](int) { return 0.0; });
    AdaptiveSettings settings = settings_with(0.01, 1);
    for (const double floor : {0.1, 0.0}) {
        settings.floor = floor;
        AdaptiveSampler sampler(settings, two_channels(), 0, buffer.layout());
        sampler.decide(buffer);
        CHECK(sampler.done());
        CHECK(sampler.progress().error == 0);
    }
}

TEST_CASE("decisions are written to bytes and read back", "[adaptive][record][law3]") {
    const FrameBuffer buffer = flickering(
        2, [](int pixel) { return 1.0 + pixel; }, [](int pixel) { return 0.1 * pixel; });
    AdaptiveSampler sampler(settings_with(0.012, 1), two_channels(), 0, buffer.layout());
    std::string bytes;
    sampler.append_record(bytes);  // before the first decision
    AdaptiveSampler fresh(settings_with(0.012, 1), two_channels(), 0, buffer.layout());
    REQUIRE(fresh.restore_record(bytes).ok());
    CHECK(fresh.errors().empty());
    sampler.decide(buffer);
    bytes.clear();
    sampler.append_record(bytes);
    REQUIRE(fresh.restore_record(bytes).ok());
    std::string again;
    fresh.append_record(again);
    CHECK((again == bytes));
    CHECK(fresh.progress().open_pixels == sampler.progress().open_pixels);
    fresh.decide(buffer);
    sampler.decide(buffer);
    again.clear();
    bytes.clear();
    fresh.append_record(again);
    sampler.append_record(bytes);
    CHECK((again == bytes));
    CHECK_FALSE(fresh.restore_record(bytes.substr(1)).ok());
}

TEST_CASE("invalid settings are refused by name", "[adaptive][law7]") {
    const auto channels = two_channels();
    const auto refusal = [&](const AdaptiveSettings& settings, ChannelId beauty = 0) {
        const Status status = AdaptiveSampler::check(settings, channels, beauty);
        REQUIRE_FALSE(status.ok());
        return status.error();
    };
    CHECK(AdaptiveSampler::check({}, channels, 0).ok());
    AdaptiveSettings settings;
    CHECK(refusal(settings, invalid_channel).message.find("without a beauty") != std::string::npos);
    settings.channels = {{"direkt", 1, {"job.toml", 7, 3}}};
    CHECK(refusal(settings).hint == "did you mean 'direct'?");
    CHECK(refusal(settings).line == 7);
    settings.channels = {{"z", 1, {}}};
    CHECK(refusal(settings).message.find("not averaged by the pixel filter") != std::string::npos);
    settings.channels = {{"direct", 0, {}}};
    CHECK(refusal(settings).message.find("weight 0") != std::string::npos);
    settings.channels = {{"direct", 1, {}}, {"direct", 2, {}}};
    CHECK(refusal(settings).message.find("twice") != std::string::npos);
    settings = {};
    settings.error = 0;
    CHECK(refusal(settings).message.find("an error of 0") != std::string::npos);
    settings = {};
    settings.min_samples = 100000;
    CHECK(refusal(settings).message.find("min_samples up to max_samples") != std::string::npos);
    settings = {};
    settings.floor = -1;
    CHECK(refusal(settings).message.find("a floor of -1") != std::string::npos);
    settings = {};
    settings.neighbourhood = 9;
    CHECK(refusal(settings).message.find("0 to 8 pixels") != std::string::npos);
}

}  // namespace raylex::display
