// Raster splats of the frame buffer against direct sums, in any order and through the record.
#include <algorithm>

#include <catch2/catch.hpp>

#include "display/buffer/frame_buffer/frame_buffer.h"
#include "display/buffer/pixel_filter.h"
#include "tests/services/helpers.h"

namespace raylex::display {
namespace {

constexpr int width = 6, height = 4, splats = 300;

PixelFilter filter_named(const std::string& name) {
    auto filter = make_pixel_filter(name, {});
    REQUIRE(filter.ok());
    return *filter;
}

struct Splat {
    CameraRow row;
    RgbD color;
};

std::vector<Splat> random_splats() {
    std::vector<Splat> list;
    test::Random random(7);
    for (int i = 0; i < splats; ++i) {
        Splat splat;
        splat.row.screen_x = -2 + (width + 4) * random.uniform_float();
        splat.row.screen_y = -2 + (height + 4) * random.uniform_float();
        if (i % 7 == 0) splat.row.screen_x = std::floor(splat.row.screen_x);  // on an edge of the box
        splat.row.filter_weight = i % 3 == 0 ? 0.25f : 1.0f;
        splat.color = RgbD(random.uniform(), 1e4 * random.uniform(), random.uniform() - 0.5);
        list.push_back(splat);
    }
    return list;
}

void feed(FrameBuffer& buffer, std::span<const Splat> list) {
    SampleTable table(buffer.channels(), splats);
    table.begin({});
    std::vector<int> rows;
    for (const Splat& splat : list) {
        const int row = table.add_camera_row(splat.row);
        rows.push_back(row);
        for (int c = 0; c < 3; ++c) table.raw_values(0)[3 * row + c] = splat.color[c];
    }
    table.touch(0);
    buffer.splat(table, rows);
    buffer.count_light_paths(list.size());
}

}  // namespace

TEST_CASE("raster splats are weighted by the kernel wherever they land, in any order", "[framebuffer][splat][law3]") {
    const std::vector<ChannelDefinition> channels{test::expression_channel("beauty", "C.*")};
    const std::vector<Splat> list = random_splats();
    for (const char* name : {"box", "mitchell"}) {
        const PixelFilter filter = filter_named(name);
        FrameBuffer whole({width, height}, channels, nullptr, &filter),
            first({width, height}, channels, nullptr, &filter), second({width, height}, channels, nullptr, &filter);
        feed(whole, list);
        std::vector<Splat> backwards(list.rbegin(), list.rend());
        feed(first, {backwards.data(), 100});
        feed(second, {backwards.data() + 100, backwards.size() - 100});
        std::string bytes;
        second.append_record(bytes);
        auto restored = FrameBuffer::from_record(bytes);
        REQUIRE(restored.ok());
        REQUIRE(first.merge(*restored).ok());
        CHECK(first.resolve(0) == whole.resolve(0));
        CHECK(first.light_path_count() == splats);
        // Continue after a restart.
        restored->adopt_kernels(second);
        feed(*restored, {backwards.data(), 100});
        CHECK(restored->resolve(0) == whole.resolve(0));

        const std::vector<double> image = whole.resolve(0);
        double total = 0, sent = 0;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                for (int c = 0; c < 3; ++c) {
                    double sum = 0, magnitude = 0;
                    for (const Splat& splat : list) {
                        float dx = splat.row.screen_x - (static_cast<float>(x) + 0.5f);
                        if (dx == -filter.radius_x()) dx = std::nextafter(dx, 0.0f);
                        const double term = static_cast<double>(filter.evaluate(
                                                dx, splat.row.screen_y - (static_cast<float>(y) + 0.5f))) *
                                            static_cast<double>(splat.row.filter_weight) * splat.color[c];
                        sum += term;
                        magnitude += std::abs(term);
                    }
                    const double pixel = image[static_cast<std::size_t>(3 * (y * width + x) + c)];
                    // 300 additions in double.
                    CHECK(std::abs(pixel - sum * width * height / splats) <=
                          300 * 0x1p-52 * magnitude * width * height / splats);
                    if (c == 1) total += pixel;
                }
        for (const Splat& splat : list)
            if (splat.row.screen_x >= 0 && splat.row.screen_x < width && splat.row.screen_y >= 0 &&
                splat.row.screen_y < height)
                sent += static_cast<double>(splat.row.filter_weight) * splat.color[1];
        // A box is a partition of the image: even splats on an edge are neither lost nor counted twice.
        if (std::string(name) == "box") CHECK(total == Approx(sent * width * height / splats).epsilon(1e-6));
    }
}

TEST_CASE("channels that raster splats cannot fill are refused", "[framebuffer][splat][law7]") {
    const PixelFilter filter = filter_named("gaussian");
    std::vector<ChannelDefinition> channels{test::expression_channel("beauty", "C.*")};
    CHECK(FrameBuffer::create({width, height}, channels, nullptr, &filter).ok());
    channels[0].rule = FilterRule::max;
    CHECK_FALSE(FrameBuffer::create({width, height}, channels, nullptr, &filter).ok());
    channels[0].rule = FilterRule::filter;
    channels.push_back(channels[0]);
    channels[1].name = "half";
    channels[1].source = 0;
    channels[1].statistic = Statistic::even;
    const auto refused = FrameBuffer::create({width, height}, channels, nullptr, &filter);
    REQUIRE_FALSE(refused.ok());
    CHECK(refused.error().to_string().find("'half' is one half") != std::string::npos);
    channels.pop_back();
    FrameBuffer with({width, height}, channels, nullptr, &filter), without({width, height}, channels);
    CHECK_FALSE(with.merge(without).ok());
}

}  // namespace raylex::display
