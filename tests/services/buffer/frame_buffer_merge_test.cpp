// Law 3 for the record: threads, shards and sessions can deliver the blocks of an image in any way.
#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <thread>

#include <catch2/catch.hpp>

#include "display/buffer/frame_buffer/frame_buffer.h"
#include "display/services/samples/display_services.h"
#include "tests/services/helpers.h"

namespace raylex::display {
namespace {

using test::plain_channel;
using test::Random;

constexpr int merged_width = 5, merged_height = 3, blocks_per_pixel = 12, block_size = 16;

std::vector<ChannelDefinition> every_rule() {
    std::vector<ChannelDefinition> channels{
        test::expression_channel("light", "CL"),
        plain_channel("statistics", ChannelType::rgb),
        plain_channel("zmin", ChannelType::point, FilterRule::zmin),
        plain_channel("zmax", ChannelType::integer, FilterRule::zmax),
        plain_channel("min", ChannelType::rgb, FilterRule::min),
        plain_channel("max", ChannelType::real, FilterRule::max),
        plain_channel("average", ChannelType::rgb, FilterRule::average),
        plain_channel("sum", ChannelType::real, FilterRule::sum),
    };
    channels[1].statistics = true;
    return channels;
}

/// Fills `table` with one block of one pixel: values over many orders of magnitude, with some equal depths.
void fill_block(SampleTable& table, int pixel, int block) {
    Random random(static_cast<std::uint64_t>(pixel * 1000 + block));
    std::vector<CameraRow> rows = test::pixel_rows(pixel % merged_width, pixel / merged_width,
                                                   static_cast<std::uint64_t>(block * block_size), block_size);
    for (CameraRow& row : rows) row.filter_weight = random.below(4) == 0 ? -1.2f : 1.2f;
    table.begin(rows);
    DisplayServices services(table);
    const auto value = [&] { return static_cast<float>(std::ldexp(random.uniform() - 0.3, random.below(60) - 40)); };
    const auto color = [&] { return Rgb(value(), value(), value()); };
    for (int row = 0; row < block_size; ++row) {
        services.write_opacity(row, Rgb(random.uniform_float()));
        if (random.below(3) == 0) continue;
        services.write_distance(row, static_cast<float>(random.below(40)));
        services.splat(0, row, color());
        services.write(1, row, color());
        services.write(2, row, color());
        services.write(3, row, static_cast<std::int32_t>(random.below(1000)));
        services.write(4, row, color());
        services.write(5, row, value());
        services.write(6, row, color());
        services.write(7, row, value());
    }
}

std::vector<std::uint64_t> bits_of(const FrameBuffer& buffer) {
    std::vector<double> all = buffer.resolve_alpha();
    for (ChannelId id = 0; id < static_cast<ChannelId>(buffer.channels().size()); ++id) {
        for (const double v : buffer.resolve(id)) all.push_back(v);
        for (const double v : buffer.resolve_variance_of_mean(id)) all.push_back(v);
    }
    std::vector<std::uint64_t> bits;
    for (const double v : all) bits.push_back(std::bit_cast<std::uint64_t>(v));
    for (int i = 0; i < merged_width * merged_height; ++i)
        bits.push_back(buffer.sample_count(i % merged_width, i / merged_width));
    return bits;
}

std::vector<std::pair<int, int>> all_blocks() {
    std::vector<std::pair<int, int>> blocks;
    for (int pixel = 0; pixel < merged_width * merged_height; ++pixel)
        for (int block = 0; block < blocks_per_pixel; ++block) blocks.emplace_back(pixel, block);
    return blocks;
}

FrameBuffer render_in_order() {
    const std::vector<ChannelDefinition> channels = every_rule();
    FrameBuffer buffer({merged_width, merged_height}, channels);
    SampleTable table(channels, block_size);
    for (const auto& [pixel, block] : all_blocks()) {
        fill_block(table, pixel, block);
        buffer.accumulate(table);
    }
    return buffer;
}

void shuffle(std::vector<std::pair<int, int>>& blocks, Random& random) {
    for (std::size_t i = blocks.size(); i > 1; --i) std::swap(blocks[i - 1], blocks[random.bits() % i]);
}

TEST_CASE("blocks assigned to random buffers and merged in random order give the same bits", "[frame_buffer][law3]") {
    const std::vector<std::uint64_t> expected = bits_of(render_in_order());
    const std::vector<ChannelDefinition> channels = every_rule();
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        Random random(seed);
        std::vector<std::pair<int, int>> blocks = all_blocks();
        shuffle(blocks, random);
        std::vector<FrameBuffer> buffers;
        for (int i = 0; i < 4; ++i) buffers.emplace_back(FrameBufferLayout{merged_width, merged_height}, channels);
        SampleTable table(channels, block_size);
        for (const auto& [pixel, block] : blocks) {
            fill_block(table, pixel, block);
            buffers[static_cast<std::size_t>(random.below(4))].accumulate(table);
        }
        while (buffers.size() > 1) {
            const auto to = static_cast<std::size_t>(random.below(static_cast<int>(buffers.size())));
            std::swap(buffers[to], buffers.back());
            FrameBuffer last = std::move(buffers.back());
            buffers.pop_back();
            REQUIRE(buffers[static_cast<std::size_t>(random.below(static_cast<int>(buffers.size())))].merge(last));
        }
        CHECK(bits_of(buffers[0]) == expected);
    }
}

TEST_CASE("threads that share a buffer by pixel give the same bits", "[frame_buffer][law3]") {
    const std::vector<std::uint64_t> expected = bits_of(render_in_order());
    const std::vector<ChannelDefinition> channels = every_rule();
    FrameBuffer buffer({merged_width, merged_height}, channels);
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([&, t] {
            SampleTable table(channels, block_size);
            for (const auto& [pixel, block] : all_blocks()) {
                if (pixel % 4 != t) continue;
                fill_block(table, pixel, blocks_per_pixel - 1 - block);
                buffer.accumulate(table);
            }
        });
    for (std::thread& thread : threads) thread.join();
    CHECK(bits_of(buffer) == expected);
}

TEST_CASE("a batch with several blocks gives the same bits as single blocks", "[frame_buffer][law3]") {
    const std::vector<ChannelDefinition> channels{plain_channel("v", ChannelType::real)};
    Random random(4);
    std::vector<double> values(100);
    for (double& v : values) v = random.uniform();
    const auto render = [&](int batch) {
        FrameBuffer buffer({1, 1}, channels);
        SampleTable table(channels, batch);
        for (int done = 0; done < 100; done += batch) {
            const int count = std::min(batch, 100 - done);
            table.begin(test::pixel_rows(0, 0, static_cast<std::uint64_t>(done), count));
            std::copy_n(values.begin() + done, count, table.raw_values(0));
            table.touch(0);
            buffer.accumulate(table);
        }
        return buffer.resolve(0)[0];
    };
    const double expected = render(16);
    CHECK(render(32) == expected);
    CHECK(render(64) == expected);
    CHECK(render(112) == expected);
}

TEST_CASE("records of different images do not merge, and the error gives the reason", "[frame_buffer][law7]") {
    std::vector<ChannelDefinition> channels = every_rule();
    FrameBuffer buffer = render_in_order();
    const std::vector<std::uint64_t> before = bits_of(buffer);
    CHECK_FALSE(buffer.merge(FrameBuffer({merged_width, merged_height + 1}, channels)));
    CHECK_FALSE(buffer.merge(FrameBuffer({merged_width, merged_height, 32}, channels)));
    CHECK_FALSE(buffer.merge(FrameBuffer({merged_width, merged_height}, std::span(channels).first(3))));
    channels[0].expression = "CDL";
    const Status status = buffer.merge(FrameBuffer({merged_width, merged_height}, channels));
    REQUIRE_FALSE(status);
    CHECK(status.error().message.find("'light'") != std::string::npos);
    CHECK(bits_of(buffer) == before);
}

}  // namespace
}  // namespace raylex::display
