// Splat mode of the frame buffer against direct sums, and its laws.
#include <algorithm>
#include <numeric>

#include <catch2/catch.hpp>

#include "display/buffer/frame_buffer/frame_buffer.h"
#include "display/buffer/pixel_filter.h"
#include "tests/services/helpers.h"

namespace raylex::display {
namespace {

constexpr int width = 7, height = 5, samples = 20;

/// One sample of one pixel, inside the image or around it.
struct Sample {
    CameraRow row;
    RgbD a, b;
    double opacity = 0;
};

std::vector<ChannelDefinition> split_channels() {
    return {test::expression_channel("beauty", "C.*"), test::expression_channel("a", "CDL"),
            test::expression_channel("b", "CSL")};
}

/// Samples spread evenly over the image and `reach` pixels around it.
std::vector<Sample> even_samples(int reach, std::uint64_t seed) {
    std::vector<Sample> list;
    test::Random random(seed);
    const auto color = [&] { return RgbD(random.uniform(), 10 * random.uniform(), random.uniform() - 0.5); };
    for (int y = -reach; y < height + reach; ++y)
        for (int x = -reach; x < width + reach; ++x)
            for (int i = 0; i < samples; ++i) {
                Sample sample;
                sample.row.pixel_x = x;
                sample.row.pixel_y = y;
                sample.row.screen_x = static_cast<float>(x) + random.uniform_float();
                sample.row.screen_y = static_cast<float>(y) + random.uniform_float();
                sample.row.sample = static_cast<std::uint64_t>(i);
                sample.a = color();
                sample.b = color();
                sample.opacity = random.uniform();
                list.push_back(sample);
            }
    return list;
}

/// Adds a block of at most 16 samples of one pixel.
void feed(FrameBuffer& buffer, std::span<const Sample> block) {
    SampleTable table(buffer.channels(), 16);
    std::vector<CameraRow> rows;
    for (const Sample& sample : block) rows.push_back(sample.row);
    table.begin(rows);
    for (std::size_t i = 0; i < block.size(); ++i) {
        const RgbD colors[3] = {block[i].a + block[i].b, block[i].a, block[i].b};
        for (ChannelId id = 0; id < 3; ++id)
            for (std::size_t c = 0; c < 3; ++c) table.raw_values(id)[3 * i + c] = colors[id][static_cast<int>(c)];
        table.opacity[i] = RgbD(block[i].opacity);
    }
    for (ChannelId id = 0; id < 3; ++id) table.touch(id);
    buffer.accumulate(table);
}

std::vector<std::span<const Sample>> blocks_of(const std::vector<Sample>& list) {
    std::vector<std::span<const Sample>> blocks;
    for (std::size_t first = 0; first < list.size(); first += samples) {
        blocks.push_back({&list[first], 16});
        blocks.push_back({&list[first + 16], samples - 16});
    }
    return blocks;
}

TEST_CASE("a splatted pixel is the kernel-weighted mean of all samples in reach", "[splat]") {
    for (const char* name : {"box", "gaussian", "mitchell", "triangle"}) {
        CAPTURE(name);
        const PixelFilter kernel = *make_pixel_filter(name, {});
        const int reach = splat_reach(kernel.radius_x());
        CHECK(reach == (std::string(name) == "box" ? 0 : std::string(name) == "gaussian" ? 1 : 2));
        const std::vector<Sample> list = even_samples(reach, 5);
        FrameBuffer buffer({width, height}, split_channels(), &kernel);
        for (const auto& block : blocks_of(list)) feed(buffer, block);
        const std::vector<double> image = buffer.resolve(1), alpha = buffer.resolve_alpha();
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                double weight = 0, sum = 0, covered = 0, size = 0;
                for (const Sample& sample : list) {
                    const double w =
                        static_cast<double>(kernel.evaluate(sample.row.screen_x - (static_cast<float>(x) + 0.5f),
                                                            sample.row.screen_y - (static_cast<float>(y) + 0.5f)));
                    weight += w;
                    sum += w * sample.a.g;
                    covered += w * sample.opacity;
                    size += std::abs(w) * 10;
                }
                const auto pixel = static_cast<std::size_t>(y * width + x);
                // Some 500 terms of similar size in a different order: at most 500 rounding errors of 2^-53 of their
                // sum.
                const double rounding = 500 * 0x1p-53 * size / std::abs(weight);
                CHECK(image[3 * pixel + 1] == Approx(sum / weight).margin(rounding));
                CHECK(alpha[pixel] == Approx(covered / weight).margin(rounding));
                CHECK(buffer.sample_count(x, y) == samples);
            }
    }
}

TEST_CASE("splatted layers sum to the beauty, and their order does not matter", "[splat][law1][law3]") {
    const PixelFilter kernel = *make_pixel_filter("gaussian", {});
    const std::vector<Sample> list = even_samples(1, 9);
    std::vector<std::span<const Sample>> blocks = blocks_of(list);
    FrameBuffer forwards({width, height}, split_channels(), &kernel),
        backwards({width, height}, split_channels(), &kernel);
    for (const auto& block : blocks) feed(forwards, block);
    std::reverse(blocks.begin(), blocks.end());
    FrameBuffer first({width, height}, split_channels(), &kernel);
    for (std::size_t i = 0; i < blocks.size(); ++i) feed(i % 3 == 0 ? first : backwards, blocks[i]);
    REQUIRE(backwards.merge(first).ok());
    for (ChannelId id = 0; id < 3; ++id) CHECK(forwards.resolve(id) == backwards.resolve(id));
    CHECK(forwards.resolve_alpha() == backwards.resolve_alpha());
    const std::vector<double> whole = forwards.resolve(0), a = forwards.resolve(1), b = forwards.resolve(2);
    for (std::size_t i = 0; i < whole.size(); ++i)
        CHECK(std::abs(a[i] + b[i] - whole[i]) <= 1e-12 * (std::abs(a[i]) + std::abs(b[i]) + std::abs(whole[i])));
    CHECK(forwards.rejected_count() == 0);
}

TEST_CASE("rules other than the pixel filter use a pixel's own samples in splat mode, too", "[splat]") {
    const PixelFilter kernel = *make_pixel_filter("gaussian", {});
    std::vector<ChannelDefinition> channels = split_channels();
    channels[1].rule = FilterRule::max;
    const std::vector<Sample> list = even_samples(1, 2);
    FrameBuffer splatted({width, height}, channels, &kernel), plain({width, height}, channels);
    for (const auto& block : blocks_of(list)) {
        feed(splatted, block);
        const CameraRow& row = block.front().row;
        if (row.pixel_x >= 0 && row.pixel_y >= 0 && row.pixel_x < width && row.pixel_y < height) feed(plain, block);
    }
    CHECK(splatted.resolve(1) == plain.resolve(1));
    CHECK(splatted.resolve(2) != plain.resolve(2));
}

TEST_CASE("splat mode refuses statistics, and records of the other mode", "[splat][law7]") {
    const PixelFilter gaussian = *make_pixel_filter("gaussian", {}), box = *make_pixel_filter("box", {});
    std::vector<ChannelDefinition> channels = split_channels();
    FrameBuffer splatted({width, height}, channels, &gaussian);
    CHECK_FALSE(splatted.merge(FrameBuffer({width, height}, channels)).ok());
    CHECK_FALSE(splatted.merge(FrameBuffer({width, height}, channels, &box)).ok());
    channels[1].statistics = true;
    const auto refused = FrameBuffer::create({width, height}, channels, &gaussian);
    REQUIRE_FALSE(refused.ok());
    CHECK(refused.error().message.find("'a' has statistics") != std::string::npos);
    CHECK(FrameBuffer::create({width, height}, channels).ok());
}

}  // namespace
}  // namespace raylex::display
