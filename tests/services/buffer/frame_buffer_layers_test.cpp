// One channel with several outputs: layers that combine another channel's samples by rules of their own.
#include <catch2/catch.hpp>
#include <limits>
#include <string>

#include "display/buffer/frame_buffer/frame_buffer.h"
#include "display/buffer/frame_buffer/memory_estimate.h"
#include "display/services/channel_settings.h"
#include "display/services/samples/display_services.h"
#include "tests/services/helpers.h"

namespace raylex::display {
namespace {

/// Catch shows the text if the check fails; it is not part of the expression.
bool contains(const std::string& text, const std::string& part) {
    UNSCOPED_INFO(text);
    return text.find(part) != std::string::npos;
}

using test::plain_channel;

constexpr float infinite = std::numeric_limits<float>::infinity();
const SourceLocation here{"job.toml", 3, 1};

/// The channels color (filter), depth (zmin), light (an expression), and layers of each.
std::vector<ChannelDefinition> channels() {
    std::vector<ChannelDefinition> list{plain_channel("color", ChannelType::rgb),
                                        plain_channel("depth", ChannelType::real, FilterRule::zmin, infinite),
                                        test::expression_channel("light", "CL")};
    const Status added = add_layers({{"brightest", "color", FilterRule::max, here},
                                     {"nearest", "color", FilterRule::zmin, here},
                                     {"mean_depth", "depth", FilterRule::average, here},
                                     {"strongest", "light", FilterRule::max, here},
                                     {"all_light", "light", FilterRule::sum, here}},
                                    list);
    REQUIRE(added);
    return list;
}
constexpr ChannelId color = 0, depth = 1, light = 2, brightest = 3, nearest = 4, mean_depth = 5, strongest = 6,
                    all_light = 7;

}  // namespace

TEST_CASE("values sent to a channel reach every output, each by its own rule", "[frame_buffer][display_services]") {
    const std::vector<ChannelDefinition> list = channels();
    SampleTable table(list, 4);
    DisplayServices services(table);
    FrameBuffer buffer({1, 1}, list);
    table.begin(test::pixel_rows(0, 0, 0, 4));
    const float depths[] = {5, 3, 4};
    for (int row = 0; row < 3; ++row) {  // the fourth row has no value
        CHECK(services.write(color, row, Rgb(static_cast<float>(row + 1))));
        CHECK(services.write(depth, row, depths[row]));
        CHECK(services.splat(light, row, Rgb(2.0f * static_cast<float>(row))));
        services.write_distance(row, depths[row]);
        services.write_opacity(row, 1.0f);
    }
    buffer.accumulate(table);
    CHECK(buffer.resolve(color)[0] == 6.0 / 4);
    CHECK(buffer.resolve(brightest)[0] == 3);
    CHECK(buffer.resolve(nearest)[0] == 2);  // the value of row 1, at depth 3
    CHECK(buffer.resolve(depth)[0] == 3);
    CHECK(buffer.resolve(mean_depth)[0] == 4);  // over the written rows
    CHECK(buffer.resolve(light)[0] == 6.0 / 4);
    CHECK(buffer.resolve(strongest)[0] == 4);
    CHECK(buffer.resolve(all_light)[0] == 6);

    // A layer equals a channel of its own with that rule, bit for bit, for any number of batches and any order of
    // merging.
    FrameBuffer first({1, 1}, list), second({1, 1}, list);
    for (int block = 0; block < 2; ++block) {
        table.begin(test::pixel_rows(0, 0, 16 * static_cast<std::uint64_t>(block), 4));
        services.write(color, 2, Rgb(10.0f + static_cast<float>(block)));
        services.write_distance(2, 7.0f - static_cast<float>(block));
        (block == 0 ? first : second).accumulate(table);
    }
    REQUIRE(second.merge(first));
    CHECK(second.resolve(brightest)[0] == 11);
    CHECK(second.resolve(nearest)[0] == 11);
}

TEST_CASE("values cannot be sent to layers, and patterns do not see them", "[display_services][law7]") {
    const std::vector<ChannelDefinition> list = channels();
    SampleTable table(list, 4);
    DisplayServices services(table);
    table.begin(test::pixel_rows(0, 0, 0, 4));
    REQUIRE(services.get_display_channels().size() == 3);
    CHECK(services.get_display_channels()[2].id == light);
    CHECK_FALSE(services.write(nearest, 0, Rgb(1)));
    CHECK_FALSE(services.splat(all_light, 0, Rgb(1)));
    const std::int32_t rows[] = {0, 1};
    const Rgb values[] = {Rgb(1), Rgb(2)};
    CHECK_FALSE(services.write(nearest, std::span(rows), std::span(values)));
    CHECK(services.refusals()[nearest].of(Refusal::unknown_channel) == 3);
    CHECK(refusal_warnings(list, services.refusals()).front() ==
          "channel 'nearest' refused 3 calls: 3 to a layer that uses another channel's samples");
    for (ChannelId id = 0; id < table.channel_count(); ++id) CHECK_FALSE(table.touched(id));
}

TEST_CASE("a layer needs the memory of its rule, and none in the sample table", "[frame_buffer]") {
    const std::vector<MemoryItem> items = frame_buffer_memory({.width = 10, .height = 10}, channels());
    REQUIRE(items.size() == 9);
    CHECK(items[0].bytes == 100 * (8 + 2 * 16));  // no layer makes its source keep statistics
    CHECK(items[1 + color].bytes == 100 * 48);
    CHECK(items[1 + brightest].bytes == 100 * (3 * 8 + 8));    // picked values and number of rows
    CHECK(items[1 + nearest].bytes == 100 * (3 * 8 + 8 + 4));  // plus the depth
    CHECK(items[1 + mean_depth].bytes == 100 * (16 + 8));
}

TEST_CASE("layers of unknown channels, or with impossible rules, are refused", "[display_services][law7]") {
    std::vector<ChannelDefinition> list = channels();
    list.push_back(plain_channel("id", ChannelType::integer, FilterRule::zmin));
    const auto refused = [&](const LayerRequest& request) {
        const std::size_t before = list.size();
        const Status added = add_layers({request}, list);
        REQUIRE_FALSE(added);
        CHECK(list.size() == before);
        CHECK(added.error().line == 3);
        return added.error().to_string();
    };
    CHECK(contains(refused({"x", "colour", FilterRule::max, here}), "unknown channel 'colour'"));
    CHECK(contains(refused({"x", "colour", FilterRule::max, here}), "did you mean 'color'?"));
    CHECK(contains(refused({"x", "nearest", FilterRule::max, here}), "unknown channel 'nearest'"));
    CHECK(contains(refused({"light", "color", FilterRule::max, here}), "name 'light' is taken"));
    CHECK(contains(refused({"x", "id", FilterRule::average, here}), "contains integers"));
    ChannelDefinition stray = plain_channel("stray", ChannelType::rgb);
    stray.source = depth;  // of another type
    list.push_back(stray);
    CHECK_FALSE(FrameBuffer::create({.width = 1, .height = 1}, list));
}

}  // namespace raylex::display
