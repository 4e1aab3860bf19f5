#include "display/buffer/frame_buffer/frame_buffer.h"

#include <algorithm>
#include <cstring>
#include <functional>
#include <limits>

#include <catch2/catch.hpp>

#include "display/buffer/pixel_filter.h"
#include "display/services/samples/display_services.h"
#include "tests/services/helpers.h"

namespace raylex::display {
namespace {

using test::pixel_rows;
using test::plain_channel;
using test::Random;

constexpr float infinity = std::numeric_limits<float>::infinity();

/// Adds `samples` samples of pixel (0, 0) in batches of 256, and calls `fill(table, row, sample)` for each.
void feed(FrameBuffer& buffer, std::span<const ChannelDefinition> channels, std::uint64_t samples,
          const std::function<void(SampleTable&, int, std::uint64_t)>& fill) {
    SampleTable table(channels, 256);
    for (std::uint64_t done = 0; done < samples;) {
        const int count = static_cast<int>(std::min<std::uint64_t>(256, samples - done));
        table.begin(pixel_rows(0, 0, done, count));
        for (int row = 0; row < count; ++row) fill(table, row, done + static_cast<std::uint64_t>(row));
        buffer.accumulate(table);
        done += static_cast<std::uint64_t>(count);
    }
}

TEST_CASE("a channel with a different scale has the same digits", "[frame_buffer][law3]") {
    const auto values_at = [](int scale) {
        std::vector<ChannelDefinition> channels{test::expression_channel("light", "CL"),
                                                plain_channel("v", ChannelType::rgb),
                                                plain_channel("average", ChannelType::rgb, FilterRule::average)};
        channels[1].statistics = true;
        for (ChannelDefinition& each : channels) each.scale_exponent = scale;
        FrameBuffer buffer({1, 1}, channels);
        Random random(7);
        feed(buffer, channels, 1000, [&](SampleTable& table, int row, std::uint64_t) {
            for (int i = 0; i < 3; ++i) {
                const double value = std::ldexp(random.uniform(), scale);
                for (ChannelId id = 0; id < 3; ++id) table.raw_values(id)[3 * row + i] = value;
            }
            for (ChannelId id = 0; id < 3; ++id) table.touch(id);
        });
        CHECK(buffer.rejected_count() == 0);
        std::vector<double> found;
        for (ChannelId id = 0; id < 3; ++id)
            for (const double each : buffer.resolve(id)) found.push_back(std::ldexp(each, -scale));
        for (const double each : buffer.resolve_variance_of_mean(1)) found.push_back(std::ldexp(each, -2 * scale));
        return found;
    };
    const std::vector<double> usual = values_at(0);
    for (const int scale : {-256, -80, -1, 1, 66, 256}) {
        CAPTURE(scale);
        CHECK(values_at(scale) == usual);  // scaling by a power of two does not round
    }
    std::vector<ChannelDefinition> channels{test::expression_channel("a", "CL"), test::expression_channel("b", "CDL")};
    channels[1].scale_exponent = 3;
    CHECK(!FrameBuffer::create({1, 1}, channels).ok());
    for (const int scale : {257, -257, std::numeric_limits<int>::min()}) {
        channels[0].scale_exponent = channels[1].scale_exponent = scale;
        CHECK(!FrameBuffer::create({1, 1}, channels).ok());
    }
}

TEST_CASE("statistics survive an offset of 1e6", "[frame_buffer][statistical]") {
    std::vector<ChannelDefinition> channels{plain_channel("v", ChannelType::rgb)};
    channels[0].statistics = true;
    FrameBuffer buffer({1, 1}, channels);
    constexpr std::uint64_t n = 1 << 16;
    Random random(5);
    std::vector<double> values;
    feed(buffer, channels, n, [&](SampleTable& table, int row, std::uint64_t) {
        values.push_back(1e6 + random.normal());
        for (int c = 0; c < 3; ++c) table.raw_values(0)[3 * row + c] = values.back() * (c + 1);
        table.touch(0);
    });
    const std::vector<double> variance = buffer.resolve_variance_of_mean(0);
    // hard-cases.md row 41: the sample variance of n normal deviates is 1 within 3 standard errors sqrt(2 / n).
    CHECK(variance[0] * n == Approx(1).margin(3 * std::sqrt(2.0 / n)));
    long double mean = 0, squares = 0;
    for (const double v : values) mean += static_cast<long double>(v) / n;
    for (const double v : values)
        squares += (static_cast<long double>(v) - mean) * (static_cast<long double>(v) - mean);
    const auto two_pass = static_cast<double>(squares / (n - 1) / n);
    // Block sums are rounded at 2^-53 x 1.6e7 = 2e-9, and their deviations are of order 4; 1e-6 leaves a margin.
    CHECK(variance[0] == Approx(two_pass).epsilon(1e-6));
    CHECK(variance[1] == Approx(4 * two_pass).epsilon(1e-6));
    CHECK(variance[2] == Approx(9 * two_pass).epsilon(1e-6));
}

TEST_CASE("the variance of the mean predicts the scatter of means, negative weights included",
          "[frame_buffer][statistical]") {
    std::vector<ChannelDefinition> channels{plain_channel("v", ChannelType::real)};
    channels[0].statistics = true;
    const PixelFilter filter = *make_pixel_filter("mitchell", {});
    constexpr int pixels = 4000, n = 64;
    FrameBuffer buffer({pixels, 1}, channels);
    SampleTable table(channels, n);
    Random random(11);
    for (int x = 0; x < pixels; ++x) {
        std::vector<CameraRow> rows = pixel_rows(x, 0, 0, n);
        for (CameraRow& row : rows)
            row.filter_weight = filter.sample(random.uniform_float(), random.uniform_float()).weight;
        table.begin(rows);
        for (int row = 0; row < n; ++row) table.raw_values(0)[row] = 3 + 0.5 * random.normal();
        table.touch(0);
        buffer.accumulate(table);
    }
    const std::vector<double> mean = buffer.resolve(0), variance = buffer.resolve_variance_of_mean(0);
    double scatter = 0, predicted = 0;
    for (std::size_t i = 0; i < pixels; ++i) {
        scatter += (mean[i] - 3) * (mean[i] - 3) / pixels;
        predicted += variance[i] / pixels;
    }
    // 4000 squared deviations have a relative standard error of sqrt(2 / 4000) = 2.2 %; the bound is 4 of them.
    CHECK(predicted == Approx(scatter).epsilon(0.09));
}

TEST_CASE("a constant image is constant under every pixel filter", "[frame_buffer]") {
    for (const std::string& name : pixel_filter_registry().names()) {
        CAPTURE(name);
        const PixelFilter filter = *make_pixel_filter(name, {});
        const std::vector<ChannelDefinition> channels{plain_channel("v", ChannelType::rgb)};
        FrameBuffer buffer({8, 8}, channels);
        SampleTable table(channels, 16);
        Random random(3);
        for (int pixel = 0; pixel < 64; ++pixel) {
            std::vector<CameraRow> rows = pixel_rows(pixel % 8, pixel / 8, 0, 16);
            for (CameraRow& row : rows)
                row.filter_weight = filter.sample(random.uniform_float(), random.uniform_float()).weight;
            table.begin(rows);
            std::fill_n(table.raw_values(0), 48, 0.7);
            std::fill_n(table.opacity.begin(), 16, RgbD(1));
            table.touch(0);
            buffer.accumulate(table);
        }
        const std::vector<double> values = buffer.resolve(0), alpha = buffer.resolve_alpha();
        // Weighted sums of 16 terms in double: 16 x 2^-53 of their absolute sum. Weights that cancel to no less than a
        // tenth of it can increase the error tenfold. Weights that cancel completely (the sum is exactly 0) are an
        // exception: the mean is then over the count, and 0. For sinc (23 % of the weights negative) this is expected
        // in 0.7 of the 64 pixels; more than 6 have a probability below 1e-5.
        for (const double v : values)
            if (v != 0) CHECK(v == Approx(0.7).epsilon(1e-13));
        CHECK(std::count(values.begin(), values.end(), 0.0) <= 3 * (filter.has_negative_lobes() ? 6 : 0));
        for (const double a : alpha)
            if (a != 0) CHECK(a == Approx(1).epsilon(1e-13));
    }
}

TEST_CASE("rules pick the right values, by depth with ties to the smaller sample", "[frame_buffer]") {
    std::vector<ChannelDefinition> channels{plain_channel("zmin", ChannelType::real, FilterRule::zmin, infinity),
                                            plain_channel("zmax", ChannelType::integer, FilterRule::zmax),
                                            plain_channel("min", ChannelType::rgb, FilterRule::min),
                                            plain_channel("max", ChannelType::real, FilterRule::max),
                                            plain_channel("average", ChannelType::real, FilterRule::average),
                                            plain_channel("sum", ChannelType::real, FilterRule::sum)};
    FrameBuffer buffer({2, 1}, channels);
    SampleTable table(channels, 4);
    table.begin(pixel_rows(0, 0, 0, 4));
    DisplayServices services(table);
    const float depths[4] = {5, 2, 2, 9};
    for (int row = 0; row < 3; ++row) {  // row 3 hits at depth 9 but writes nothing
        const auto value = static_cast<float>(row + 1);
        services.write_distance(row, depths[row]);
        services.write(0, row, 10 * value);
        services.write(1, row, static_cast<std::int32_t>(row + 1));
        services.write(2, row, Rgb(value, -value, 4 - value));
        services.write(3, row, value);
        services.write(4, row, value);
        services.write(5, row, value);
    }
    services.write_distance(3, depths[3]);
    buffer.accumulate(table);
    CHECK(buffer.resolve(0)[0] == 20);  // samples 1 and 2 share depth 2
    CHECK(buffer.resolve(1)[0] == 1);
    const std::vector<double> minimum = buffer.resolve(2);
    CHECK(std::vector<double>(minimum.begin(), minimum.begin() + 3) == std::vector<double>{1, -3, 1});
    CHECK(buffer.resolve(3)[0] == 3);
    CHECK(buffer.resolve(4)[0] == 2);
    CHECK(buffer.resolve(5)[0] == 6);
    // The other pixel has no written values.
    CHECK(buffer.resolve(0)[1] == std::numeric_limits<double>::infinity());
    CHECK(buffer.resolve(1)[1] == 0);
    CHECK(buffer.resolve(4)[1] == 0);
}

TEST_CASE("if the nearest sample has no value of a channel, the nearest sample with a value counts", "[frame_buffer]") {
    const std::vector<ChannelDefinition> channels{plain_channel("all", ChannelType::real, FilterRule::zmin, infinity),
                                                  plain_channel("some", ChannelType::rgb, FilterRule::zmin),
                                                  plain_channel("none", ChannelType::integer, FilterRule::zmin, 9)};
    FrameBuffer buffer({1, 1}, channels);
    SampleTable table(channels, 4);
    DisplayServices services(table);
    for (int block = 0; block < 2; ++block) {
        table.begin(pixel_rows(0, 0, 16 * static_cast<std::uint64_t>(block), 4));
        const float depths[2][4] = {{5, 3, 2, 4}, {9, 2, 8, 1.5f}};
        for (int row = 0; row < 4; ++row) {
            services.write_distance(row, depths[block][row]);
            services.write(0, row, static_cast<float>(10 * block + row));
            const bool nearest = row == (block == 0 ? 2 : 3);
            if (!nearest) services.write(1, row, Rgb(static_cast<float>(10 * block + row)));
        }
        buffer.accumulate(table);
        CHECK(buffer.resolve(0)[0] == (block == 0 ? 2 : 13));
        CHECK(buffer.resolve(1)[0] == (block == 0 ? 1 : 11));
        CHECK(buffer.resolve(2)[0] == 9);
    }
}

TEST_CASE("a rule on an expression channel counts samples without light as black", "[frame_buffer]") {
    std::vector<ChannelDefinition> channels{test::expression_channel("min", "CL"),
                                            test::expression_channel("mean", "CL")};
    channels[0].rule = FilterRule::min;
    channels[1].rule = FilterRule::average;
    FrameBuffer buffer({1, 1}, channels);
    SampleTable table(channels, 4);
    for (const bool lit : {true, false}) {  // the second batch uses no channel
        table.begin(pixel_rows(0, 0, lit ? 0 : 4, 4));
        for (ChannelId id = 0; id < 2 && lit; ++id) {
            std::fill_n(table.raw_values(id), 12, 2.0);
            table.touch(id);
        }
        buffer.accumulate(table);
    }
    CHECK(buffer.resolve(0)[0] == 0);
    CHECK(buffer.resolve(1)[0] == 1);
}

TEST_CASE("pass-through rows add light, composite written values and increase alpha", "[frame_buffer]") {
    const std::vector<ChannelDefinition> channels{plain_channel("beauty", ChannelType::rgb),
                                                  plain_channel("N", ChannelType::normal),
                                                  plain_channel("z", ChannelType::real, FilterRule::zmin, infinity)};
    FrameBuffer buffer({1, 1}, channels);
    SampleTable table(channels, 2);
    table.begin(pixel_rows(0, 0, 0, 2));
    DisplayServices services(table);
    // Sample 0: a quarter-opaque leaf at 2, then a wall at 5, reported out of order. Sample 1: no hit.
    const int wall = services.add_sample(0, {5, RgbD(1), false});
    const int leaf = services.add_sample(0, {2, RgbD(0.25), false});
    services.splat(0, wall, Rgb(3));
    services.splat(0, leaf, Rgb(1));
    services.write(1, leaf, Rgb(1, 0, 0));
    services.write(1, wall, Rgb(0, 1, 0));
    services.write(2, leaf, 2.0f);
    services.write(2, wall, 5.0f);
    buffer.accumulate(table);
    CHECK(buffer.resolve(0)[0] == 2.0);       // (3 + 1) / 2 samples
    CHECK(buffer.resolve_alpha()[0] == 0.5);  // 1 - (1 - 0.25)(1 - 1) of one sample in two
    CHECK(buffer.resolve(1)[0] == 0.125);     // 0.25 / 2
    CHECK(buffer.resolve(1)[1] == 0.375);     // 0.75 x 1 / 2
    CHECK(buffer.resolve(2)[0] == 2.0);
    CHECK(buffer.sample_count(0, 0) == 2);
}

TEST_CASE("under a kernel misses count with the miss value, or with 0 if it is infinite", "[frame_buffer]") {
    const std::vector<ChannelDefinition> channels{
        plain_channel("seven", ChannelType::real, FilterRule::filter, 7),
        plain_channel("far", ChannelType::real, FilterRule::filter, infinity)};
    FrameBuffer buffer({2, 1}, channels);
    SampleTable table(channels, 4);
    table.begin(pixel_rows(0, 0, 0, 4));
    DisplayServices services(table);
    services.write(0, 1, 3.0f);
    services.write(1, 1, 8.0f);
    buffer.accumulate(table);
    table.begin(pixel_rows(1, 0, 0, 4));
    buffer.accumulate(table);
    CHECK(buffer.resolve(0)[0] == 6);  // (7 + 3 + 7 + 7) / 4
    CHECK(buffer.resolve(0)[1] == 7);
    CHECK(buffer.resolve(1)[0] == 2);  // 8 / 4
    CHECK(buffer.resolve(1)[1] == 0);
    CHECK(buffer.rejected_count() == 0);
}

TEST_CASE("sums out of range are rejected and counted, whole colours at a time", "[frame_buffer][law6]") {
    const std::vector<ChannelDefinition> channels{plain_channel("v", ChannelType::rgb),
                                                  plain_channel("w", ChannelType::rgb)};
    FrameBuffer buffer({1, 1}, channels);
    SampleTable table(channels, 16);
    const double bad[4] = {1e300, std::numeric_limits<double>::quiet_NaN(), 1e15, 1.0};
    for (std::uint64_t b = 0; b < 4; ++b) {
        table.begin(pixel_rows(0, 0, 16 * b, 16));
        std::fill_n(table.raw_values(0), 48, 1.0);
        table.raw_values(0)[4] = bad[b];
        table.touch(0);
        buffer.accumulate(table);
    }
    CHECK(buffer.rejected_count() == 3);
    CHECK(buffer.rejected_count(0) == 3);
    CHECK(buffer.rejected_count(1) == 0);
    for (const double v : buffer.resolve(0)) CHECK(v == 0.25);
    table.begin(pixel_rows(5, 0, 0, 16));  // this pixel does not exist
    buffer.accumulate(table);
    CHECK(buffer.rejected_count() == 4);
}

TEST_CASE("impossible layouts and amounts of memory are errors", "[frame_buffer][law7]") {
    const std::vector<ChannelDefinition> channels{plain_channel("v", ChannelType::rgb)};
    CHECK(FrameBuffer::create({4, 4}, channels));
    CHECK_FALSE(FrameBuffer::create({0, 4}, channels));
    CHECK_FALSE(FrameBuffer::create({4, 4, 12}, channels));
}

}  // namespace
}  // namespace raylex::display
