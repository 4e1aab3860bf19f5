// The live line of `render`: its texts about the channels' errors, and that measuring changes nothing.
#include <catch2/catch.hpp>

#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>

#include "experiments/cli/loading_line.h"
#include "experiments/cli/render/progress.h"
#include "experiments/program/console.h"
#include "support.h"
#include "support/paths.h"
#include "transport/import/pbrt/pbrt_importer.h"
#include "transport/render/render.h"

using namespace raylex::experiments;
namespace display = raylex::display;
namespace transport = raylex::transport;
using raylex::test::Folder;

namespace {

/// An image with pixels of value 1. The means of every other row deviate by `low`, those of the others by `high`, and
/// those in a corner of 8 x 8 pixels by `spot`.
struct FlatImage : transport::LiveImage {
    double low = 0, high = 0, spot = 0;
    static std::vector<double> of(const display::PixelRegion& region, double even, double odd) {
        std::vector<double> values;
        for (int y = region.y0; y < region.y1; ++y)
            for (int i = 0; i < 3 * region.width(); ++i) values.push_back(y % 2 == 0 ? even : odd);
        return values;
    }
    std::vector<double> resolve(display::ChannelId, const display::PixelRegion& region) const override {
        return of(region, 1, 1);
    }
    std::vector<double> resolve_alpha(const display::PixelRegion&) const override { return {}; }
    std::vector<double> resolve_variance_of_mean(display::ChannelId id,
                                                 const display::PixelRegion& region) const override {
        const double scale = id == 0 ? 1 : 25;  // channels have five times the beauty's error
        std::vector<double> values = of(region, scale * low * low, scale * high * high);
        if (spot > 0 && region.x0 == 0 && region.y0 == 0)
            for (int y = 0; y < 8; ++y) std::fill_n(values.begin() + 3 * region.width() * y, 24, scale * spot * spot);
        return values;
    }
};

display::ChannelDefinition light(const std::string& name, bool statistics = true) {
    display::ChannelDefinition channel;
    channel.name = name;
    channel.style = display::ChannelStyle::expression;
    channel.expression = "C.*";
    channel.statistics = statistics;
    return channel;
}

LiveErrors errors_of(const std::vector<display::ChannelDefinition>& channels, const FlatImage& image,
                     const transport::RenderProgress& now) {
    transport::RenderPlan plan;
    plan.width = 64;
    plan.height = 32;
    plan.crop = {0, 0, 64, 32};
    plan.channels = channels;
    plan.beauty = 0;
    LiveErrors errors;
    errors.begin(plan);
    transport::RenderProgress measured = now;
    measured.image = &image;
    errors.update(measured);
    return errors;
}

}  // namespace

TEST_CASE(
    "the live line has errors, their uncertainty and the time to the next mark, to the requested error, or to the "
    "end") {
    const std::vector<display::ChannelDefinition> channels{light("beauty"), light("caustics"), light("quiet", false),
                                                           light("a"),      light("b"),        light("c")};
    constexpr std::uint64_t pixels = 64 * 32;
    FlatImage image;
    image.low = image.high = 0.04;
    // 64 of 4096 samples in 10 s. Half the error takes four times as many samples: 30 s more.
    transport::RenderProgress now{64 * pixels, 4096 * pixels, 10, nullptr, nullptr};
    LiveErrors errors = errors_of(channels, image, now);
    REQUIRE(errors.errors().size() == LiveErrors::channels_at_once);
    CHECK(errors.errors().front().error == Approx(0.04));
    CHECK(errors.errors().front().uncertainty == Approx(0).margin(1e-9));
    CHECK(error_text(errors, now, 1) == "beauty 4 % and 4 more; 2 % in about 30.0 s");
    CHECK(error_text(errors, now, 4) == "beauty 4 %, caustics 20 %, a 20 %, b 20 % and 1 more; 2 % in about 30.0 s");
    CHECK(Progress::describe(now, 0, errors, 1) ==
          "  2 %  0.01 M samples/s  10.0 s, about 10 min 30 s left; beauty 4 % and 4 more; 2 % in about 30.0 s");
    // A render that ends before the next mark shows its final error: half, after four times the samples.
    now.samples_total = 256 * pixels - 1;
    CHECK(error_text(errors, now, 1) == "beauty 4 % and 4 more; 2 % at the end");
    // With a requested error, the total is the prediction.
    display::AdaptiveProgress requested;
    requested.channel = "beauty";
    requested.target = 0.01;
    now.adaptive = &requested;
    now.samples_total = 1024 * pixels;
    CHECK(error_text(errors, now, 1) == "beauty 4 % and 4 more; 1 % in about " + std::string("2 min 30 s"));
    // Squares of 0 and 0.0032, 1024 pixels each: the standard error of their mean is 0.0016 / sqrt(2047); that of the
    // root is 1 / (2 x 0.04) times that.
    image.low = 0;
    image.high = 0.04 * std::sqrt(2.0);
    errors = errors_of(channels, image, now);
    CHECK(errors.errors().front().error == Approx(0.04));
    CHECK(errors.errors().front().uncertainty == Approx(0.0016 / std::sqrt(2047.0) / 0.08));
    CHECK(error_text(errors, now, 2).starts_with("beauty 4 % +- 0.04, caustics 20 % +- 0.2 and 3 more;"));
    // One of 32 parts has all of the error, so the sum's standard error is as large as the sum. One standard error less
    // is 1 / e of the square: after 256 samples it may be 1 / (4 e), and reaches 1 / 4 by the power law.
    image.low = image.high = 0;
    image.spot = 0.04 * std::sqrt(32.0);
    now.adaptive = nullptr;
    now.samples_total = 4096 * pixels;
    errors = errors_of(channels, image, now);
    CHECK(errors.errors().front().error == Approx(0.04));
    const double least = 10 * (std::pow(4, std::log(4.0) / (1 + std::log(4.0))) - 1);
    CHECK(error_text(errors, now, 1).ends_with("; 2 % in at least " + duration_text(least)));
    // Nothing before every pixel has a block of samples.
    now.samples_done = 16 * pixels - 1;
    CHECK(errors_of(channels, image, now).errors().empty());
}

TEST_CASE("the live line measures every channel with statistics in turn, and shows the largest errors first") {
    std::vector<display::ChannelDefinition> channels{light("beauty")};
    for (int i = 0; i < 9; ++i) channels.push_back(light("c" + std::to_string(i)));
    channels[3].statistics = false;
    display::ChannelDefinition depth = light("z"), albedo = light("albedo");
    depth.style = albedo.style = display::ChannelStyle::name;
    depth.type = display::ChannelType::real;
    channels.push_back(depth);
    channels.push_back(albedo);
    constexpr std::uint64_t pixels = 64 * 32;
    FlatImage image;
    image.low = image.high = 0.04;
    transport::RenderProgress now{64 * pixels, 4096 * pixels, 10, nullptr, &image};
    transport::RenderPlan plan;
    plan.width = 64;
    plan.height = 32;
    plan.crop = {0, 0, 64, 32};
    plan.channels = channels;
    plan.beauty = 0;
    LiveErrors errors;
    errors.begin(plan);
    // 10 other channels: each update measures the beauty and three of the others.
    for (const std::size_t known : {4U, 7U, 10U, 10U}) {
        errors.update(now);
        CHECK(errors.errors().size() == known);
        CHECK(errors.further() == 10 - known);
        CHECK(errors.errors().front().name == "beauty");
        now.seconds += 100;
    }
    const std::string all = error_text(errors, now, SIZE_MAX);
    for (const char* name : {"beauty 4 %", "c0 20 %", "c8 20 %", "albedo 20 %"})
        CHECK(all.find(name) != std::string::npos);
    for (const char* name : {"c2", "z ", "more"}) CHECK(all.find(name) == std::string::npos);
    // Larger errors come before smaller ones.
    FlatImage brighter = image;
    brighter.low = brighter.high = 0.08;
    now.image = &brighter;
    errors.update(now);
    CHECK(errors.errors()[1].error == Approx(0.4));
    CHECK(errors.errors().back().error == Approx(0.2));
}

TEST_CASE("measuring errors during a render changes no bit, and they match the finished render's within a tenth",
          "[release-only][law2][gate]") {
    auto scene = transport::import_pbrt(raylex::test::source_dir() + "/experiments/scenes/cornell-color/scene.pbrt");
    REQUIRE(scene);
    transport::RenderSettings settings;
    settings.film.resolution = {64, 64};
    settings.samples.per_pixel = 768;
    LiveErrors errors;
    const auto bits = [&](bool looking) {
        settings.before_rendering = [&](const transport::RenderPlan& plan, std::vector<display::SampleSink*>&) {
            errors.begin(plan);
            return raylex::success();
        };
        auto output = transport::render(*scene, settings, [&](const transport::RenderProgress& now) {
            if (looking) errors.update(now);
        });
        REQUIRE(output);
        std::string record;
        output->frame_buffer.append_record(record);
        if (looking) {
            display::AdaptiveSettings whole;
            whole.neighbourhood = 0;
            display::AdaptiveSampler sampler(whole, output->frame_buffer.channels(), output->beauty,
                                             output->frame_buffer.layout());
            sampler.decide(output->frame_buffer);
            if (!errors.errors().empty()) {  // a fast machine may finish before the first measurement
                const double samples = static_cast<double>(errors.samples()) / (64 * 64);
                // From 16 samples on; under a light with light sampling, an error is then known to a few per cent.
                CHECK(errors.errors().front().error * std::sqrt(samples / 768) ==
                      Approx(sampler.progress().error).epsilon(0.1));
            }
        }
        return record;
    };
    CHECK((bits(true) == bits(false)));
}

TEST_CASE("on a terminal the line fits its width and names the beauty's error; elsewhere nothing is measured",
          "[release-only][gate]") {
    const Folder folder;
    const std::string command = "cd '" + folder.path() + "' && exec '" + raylex::test::binary_dir() +
                                "/raylex' render '" + raylex::test::source_dir() +
                                "/experiments/scenes/cornell-color/scene.pbrt' --resolution 64x64 --spp 2048 "
                                "--statistics direct=variance --lpe 'direct=C[DS]<L.>' -o out.exr";
    int terminal = -1;
    winsize size{24, 70, 0, 0};
    const pid_t child = forkpty(&terminal, nullptr, nullptr, &size);
    REQUIRE(child >= 0);
    if (child == 0) {
        execl("/bin/bash", "bash", "-c", command.c_str(), nullptr);
        _exit(127);
    }
    std::string said;
    char bytes[4096];
    for (ssize_t got = 0; (got = read(terminal, bytes, sizeof bytes)) > 0;)
        said.append(bytes, static_cast<std::size_t>(got));
    close(terminal);
    int status = 0;
    waitpid(child, &status, 0);
    INFO(said);
    REQUIRE(status == 0);
    bool named = false;
    for (std::size_t begin = 0; begin < said.size();) {
        const std::size_t end = std::min(said.find_first_of("\r\n", begin), said.size());
        const std::string line = said.substr(begin, end - begin);
        if (line.find("M samples/s") != std::string::npos) CHECK(line.size() < 70);
        named = named || (line.find("; beauty ") != std::string::npos && line.find(" % +- ") != std::string::npos);
        begin = end + 1;
    }
    CHECK(named);
    const auto plain = raylex::test::run_raylex(
        folder, "render '" + raylex::test::source_dir() +
                    "/experiments/scenes/cornell-color/scene.pbrt' --resolution 64x64 --spp 64 -o plain.exr");
    CHECK(plain.code == 0);
    CHECK(plain.err.find("beauty") == std::string::npos);
}

TEST_CASE("the line of loading shows what is read, the count and the time", "[progress]") {
    raylex::transport::LoadingProgress progress;
    CHECK(raylex::experiments::LoadingLine::describe(progress, 1.5) == "loading scene file, 1.50 s");
    progress.begin("meshes", 3000);
    progress.count();
    progress.count();
    CHECK(raylex::experiments::LoadingLine::describe(progress, 12.34) == "loading meshes: 2 of 3000, 12.3 s");
    raylex::experiments::LoadingLine line;  // prints nothing in the first second, and ends at once
    line.progress()->begin("images", 2);
    line.finish();
    line.finish();
}
