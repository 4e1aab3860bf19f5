// Layers of statistics: variance, mse and the two half buffers.
#include "display/buffer/frame_buffer/frame_buffer.h"

#include <catch2/catch.hpp>

#include "display/buffer/pixel_filter.h"
#include "display/services/channel_settings.h"
#include "display/services/samples/display_services.h"
#include "tests/services/helpers.h"

namespace raylex::display {
namespace {

using test::pixel_rows;
using test::plain_channel;
using test::Random;

/// "v" and its four layers of statistics.
std::vector<ChannelDefinition> with_statistics(ChannelType type = ChannelType::real) {
    std::vector<ChannelDefinition> channels{plain_channel("v", type)};
    std::vector<StatisticRequest> requests;
    for (const char* name : {"variance", "mse", "even", "odd"})
        requests.push_back(*parse_statistic_request("v", name, {}));
    REQUIRE(add_statistics(requests, channels).ok());
    return channels;
}

constexpr ChannelId value_id = 0, variance_id = 1, mse_id = 2, even_id = 3, odd_id = 4;

/// One block of up to 16 samples of pixel (x, 0), with values and filter weights by sample index.
void feed_block(FrameBuffer& buffer, SampleTable& table, int x, std::uint64_t first, std::span<const double> values,
                std::span<const float> weights) {
    std::vector<CameraRow> rows = pixel_rows(x, 0, first, static_cast<int>(values.size()));
    for (std::size_t i = 0; i < rows.size(); ++i) rows[i].filter_weight = weights[i];
    table.begin(rows);
    const auto components = static_cast<std::size_t>(component_count(table.channel(0).type));
    for (std::size_t i = 0; i < values.size(); ++i)
        for (std::size_t c = 0; c < components; ++c)
            table.raw_values(0)[i * components + c] = values[i] * static_cast<double>(c + 1);
    table.touch(0);
    buffer.accumulate(table);
}

TEST_CASE("even and odd are the images of half the samples each, whatever the weights", "[frame_buffer][statistics]") {
    const std::vector<ChannelDefinition> channels = with_statistics(ChannelType::rgb);
    FrameBuffer buffer({1, 1}, channels);
    SampleTable table(channels, 16);
    const PixelFilter filter = *make_pixel_filter("mitchell", {});
    Random random(2);
    double sum[2] = {0, 0}, weight[2] = {0, 0};
    for (std::uint64_t first = 0; first < 53; first += 16) {
        const std::size_t count = std::min<std::uint64_t>(16, 53 - first);
        std::vector<double> values(count);
        std::vector<float> weights(count);
        for (std::size_t i = 0; i < count; ++i) {
            values[i] = 10 * random.uniform();
            weights[i] = filter.sample(random.uniform_float(), random.uniform_float()).weight;
            sum[i % 2] += values[i] * static_cast<double>(weights[i]);  // blocks begin at even indices
            weight[i % 2] += static_cast<double>(weights[i]);
        }
        feed_block(buffer, table, 0, first, values, weights);
    }
    // Sums of 27 terms in a different order: at most 27 rounding errors of 2^-53 each, of terms up to 10 x 1.3.
    constexpr double rounding = 27 * 27 * 0x1p-53 * 13;
    const std::vector<double> even = buffer.resolve(even_id), odd = buffer.resolve(odd_id),
                              whole = buffer.resolve(value_id);
    for (std::size_t c = 0; c < 3; ++c) {
        const double scale = static_cast<double>(c + 1);
        CHECK(even[c] == Approx(scale * sum[0] / weight[0]).margin(rounding));
        CHECK(odd[c] == Approx(scale * sum[1] / weight[1]).margin(rounding));
        CHECK((weight[0] * even[c] + weight[1] * odd[c]) / (weight[0] + weight[1]) ==
              Approx(whole[c]).margin(rounding));
    }
}

TEST_CASE("light in only the even samples leaves the odd half at exactly zero", "[frame_buffer][statistics]") {
    const std::vector<ChannelDefinition> channels = with_statistics();
    FrameBuffer buffer({2, 1}, channels);
    SampleTable table(channels, 16);
    std::vector<double> values(16);
    for (std::size_t i = 0; i < 16; i += 2) values[i] = 0.1 * static_cast<double>(i + 1);
    feed_block(buffer, table, 0, 0, values, std::vector<float>(16, 1.0f));
    CHECK(buffer.resolve(odd_id)[0] == 0);
    CHECK(buffer.resolve(even_id)[0] == Approx(2 * buffer.resolve(value_id)[0]).epsilon(1e-15));
    CHECK(buffer.resolve(even_id, {1, 0, 2, 1}) == std::vector<double>{0});  // this pixel has no samples
}

TEST_CASE("variance is the sample variance, and mse is the variance of the mean", "[frame_buffer][statistics]") {
    const std::vector<ChannelDefinition> channels = with_statistics();
    FrameBuffer buffer({1, 1}, channels);
    SampleTable table(channels, 16);
    Random random(9);
    std::vector<double> all;
    for (std::uint64_t first = 0; first < 48; first += 16) {
        std::vector<double> values(16);
        for (double& v : values) all.push_back(v = random.normal() + 2);
        feed_block(buffer, table, 0, first, values, std::vector<float>(16, 1.0f));
    }
    double mean = 0, squares = 0;
    for (const double v : all) mean += v / 48;
    for (const double v : all) squares += (v - mean) * (v - mean);
    CHECK(buffer.resolve(variance_id)[0] == Approx(squares / 47).epsilon(1e-12));
    CHECK(buffer.resolve(mse_id)[0] == Approx(squares / 47 / 48).epsilon(1e-12));
    CHECK(buffer.resolve(mse_id) == buffer.resolve_variance_of_mean(value_id));
}

// Half the difference of independent halves estimates the error of the mean: E ((even - odd) / 2)^2 = mse.
TEST_CASE("the halves differ as mse predicts", "[frame_buffer][statistics][statistical]") {
    const std::vector<ChannelDefinition> channels = with_statistics();
    constexpr int pixels = 4000;
    FrameBuffer buffer({pixels, 1}, channels);
    SampleTable table(channels, 16);
    Random random(4);
    for (int x = 0; x < pixels; ++x) {
        std::vector<double> values(16);
        for (double& v : values) v = random.normal();
        feed_block(buffer, table, x, 0, values, std::vector<float>(16, 1.0f));
    }
    const std::vector<double> even = buffer.resolve(even_id), odd = buffer.resolve(odd_id),
                              mse = buffer.resolve(mse_id);
    double halves = 0, predicted = 0;
    for (std::size_t i = 0; i < pixels; ++i) {
        halves += (even[i] - odd[i]) * (even[i] - odd[i]) / 4 / pixels;
        predicted += mse[i] / pixels;
    }
    // 4000 squares of normal deviates: relative standard error sqrt(2 / 4000) = 2.2 %; the bound is 4 of them.
    CHECK(halves == Approx(predicted).epsilon(0.09));
    CHECK(predicted == Approx(1 / 16.0).epsilon(0.03));  // 4000 x 15 degrees of freedom: 4 x 0.6 %
}

TEST_CASE("records with statistics merge to the same bits in any order", "[frame_buffer][statistics][law3]") {
    const std::vector<ChannelDefinition> channels = with_statistics(ChannelType::rgb);
    Random random(6);
    std::vector<FrameBuffer> shards;
    FrameBuffer whole({1, 1}, channels);
    for (std::uint64_t first = 0; first < 64; first += 16) {
        SampleTable table(channels, 16);
        std::vector<double> values(16);
        for (double& v : values) v = random.uniform();
        const std::vector<float> weights(16, 1.0f);
        feed_block(whole, table, 0, first, values, weights);
        shards.emplace_back(FrameBufferLayout{1, 1}, channels);
        feed_block(shards.back(), table, 0, first, values, weights);
    }
    FrameBuffer merged({1, 1}, channels);
    for (const int i : {2, 0, 3, 1}) REQUIRE(merged.merge(shards[static_cast<std::size_t>(i)]).ok());
    for (ChannelId id = 0; id < 5; ++id) CHECK(merged.resolve(id) == whole.resolve(id));
    std::vector<ChannelDefinition> fewer = channels;
    fewer.pop_back();
    CHECK_FALSE(merged.merge(FrameBuffer({1, 1}, fewer)).ok());
}

TEST_CASE("nothing can be sent to a layer of statistics", "[frame_buffer][statistics]") {
    const std::vector<ChannelDefinition> channels = with_statistics(ChannelType::rgb);
    SampleTable table(channels, 4);
    table.begin(pixel_rows(0, 0, 0, 4));
    DisplayServices services(table);
    CHECK(services.write(value_id, 0, Rgb(1.0f)));
    CHECK_FALSE(services.write(variance_id, 0, Rgb(1.0f)));
    CHECK_FALSE(services.splat(even_id, 0, Rgb(1.0f)));
    const std::vector<std::int32_t> rows{0, 1};
    CHECK_FALSE(services.write(odd_id, rows, std::vector<Rgb>(2)));
    CHECK(services.refusals()[variance_id].total() == 1);
    CHECK(services.refusals()[odd_id].total() == 2);
}

TEST_CASE("rules and statistics by name, or errors that list the known names", "[statistics][law7]") {
    const auto text = [](const Status& status) { return status.ok() ? std::string() : status.error().to_string(); };
    const SourceLocation where{"job.toml", 3, 5};
    CHECK(parse_rule_request("v", "zmn", where).error().to_string().find("did you mean 'zmin'") != std::string::npos);
    CHECK(parse_statistic_request("v", "varance", where).error().to_string().find("'variance'") != std::string::npos);
    std::vector<ChannelDefinition> channels{plain_channel("beauty", ChannelType::rgb),
                                            plain_channel("Nn", ChannelType::normal),
                                            plain_channel("id", ChannelType::integer, FilterRule::zmin)};
    const auto rule = [&](const char* name, const char* value) {
        return apply_rules({*parse_rule_request(name, value, where)}, 0, channels);
    };
    CHECK(text(rule("Nm", "zmin")).find("did you mean 'Nn'") != std::string::npos);
    CHECK(text(rule("Nm", "zmin")).find("job.toml:3:5") != std::string::npos);
    CHECK(text(rule("beauty", "zmin")).find("the beauty always uses the pixel filter") != std::string::npos);
    CHECK(text(rule("id", "average")).find("integers") != std::string::npos);
    const RuleRequest twice = *parse_rule_request("Nn", "max", where);
    CHECK(text(apply_rules({twice, twice}, 0, channels)).find("two rules") != std::string::npos);
    REQUIRE(rule("Nn", "zmax").ok());
    CHECK(channels[1].rule == FilterRule::zmax);

    const auto statistic = [&](const char* name, const char* value) {
        return add_statistics({*parse_statistic_request(name, value, where)}, channels);
    };
    CHECK(text(statistic("Nn", "mse")).find("has the rule 'zmax', which has no statistics") != std::string::npos);
    CHECK(text(statistic("beaty", "mse")).find("did you mean 'beauty'") != std::string::npos);
    REQUIRE(statistic("beauty", "mse").ok());
    CHECK(channels.back().name == "beauty_mse");
    CHECK(text(statistic("beauty", "mse")).find("requested twice") != std::string::npos);
    CHECK(text(statistic("beauty_mse", "mse")).find("unknown channel") != std::string::npos);
    channels.push_back(plain_channel("beauty_even", ChannelType::rgb));
    CHECK(text(statistic("beauty", "even")).find("name of another channel") != std::string::npos);

    channels.back().statistic = Statistic::odd;  // made directly, from a channel with a different rule
    channels.back().source = 1;
    CHECK_FALSE(FrameBuffer::create({1, 1}, channels).ok());
    channels.back().source = 77;
    CHECK_FALSE(FrameBuffer::create({1, 1}, channels).ok());
}

}  // namespace
}  // namespace raylex::display
