#include "display/services/samples/display_services.h"

#include <array>
#include <limits>
#include <numeric>

#include <catch2/catch.hpp>

#include "display/buffer/frame_buffer/frame_buffer.h"
#include "tests/services/helpers.h"

namespace raylex::display {
namespace {

using test::plain_channel;

constexpr ChannelId color = 0, depth = 1, index = 2, light = 3;

std::vector<ChannelDefinition> four_channels() {
    return {plain_channel("color", ChannelType::rgb),
            plain_channel("depth", ChannelType::real, FilterRule::zmin, std::numeric_limits<float>::infinity()),
            plain_channel("index", ChannelType::integer, FilterRule::zmin), test::expression_channel("light", "CL")};
}

struct Fixture {
    std::vector<ChannelDefinition> channels = four_channels();
    SampleTable table{channels, 8};
    DisplayServices services{table};

    Fixture() { table.begin(test::pixel_rows(0, 0, 0, 4)); }
    [[nodiscard]] std::vector<double> values(ChannelId id, int row) const {
        const int n = component_count(table.channel(id).type);
        return {table.values(id) + row * n, table.values(id) + (row + 1) * n};
    }
};

TEST_CASE("splat adds and write replaces, only in the given row and channel", "[display_services]") {
    Fixture f;
    CHECK(f.services.splat(color, 1, Rgb(1, 2, 3)));
    CHECK(f.services.splat(color, 1, Rgb(1, 1, 1)));
    CHECK(f.values(color, 1) == std::vector<double>{2, 3, 4});
    CHECK(f.values(color, 0) == std::vector<double>{0, 0, 0});
    CHECK(f.values(color, 2) == std::vector<double>{0, 0, 0});
    CHECK(f.services.write(color, 1, Rgb(7, 8, 9)));
    CHECK(f.services.write(color, 1, Rgb(5, 5, 6)));
    CHECK(f.values(color, 1) == std::vector<double>{5, 5, 6});
    CHECK(f.services.write(index, 3, std::int32_t{-7}));
    CHECK(f.values(index, 3) == std::vector<double>{-7});
    CHECK(f.table.written(color, 1));
    CHECK_FALSE(f.table.written(color, 0));
    CHECK(f.table.touched(index));
    CHECK_FALSE(f.table.touched(light));
}

TEST_CASE("the first splat replaces an infinite miss value", "[display_services]") {
    Fixture f;
    CHECK(f.values(depth, 2) == std::vector<double>{std::numeric_limits<double>::infinity()});
    CHECK(f.services.splat(depth, 2, 1.5f));
    CHECK(f.services.splat(depth, 2, 1.5f));
    CHECK(f.values(depth, 2) == std::vector<double>{3});
    CHECK(f.services.write(depth, 2, 4.0f));
    CHECK(f.services.splat(depth, 2, 1.0f));  // adds to a written value
    CHECK(f.values(depth, 2) == std::vector<double>{5});
}

TEST_CASE("bad ids, rows and types are refused, counted per channel and change nothing", "[display_services][law7]") {
    Fixture f;
    CHECK(f.services.splat(invalid_channel, 0, 1.0f));  // a channel that was not requested
    CHECK(f.services.write(invalid_channel, 77, Rgb(1)));
    CHECK_FALSE(f.services.splat(-2, 0, 1.0f));
    CHECK_FALSE(f.services.splat(4, 0, Rgb(1)));
    CHECK_FALSE(f.services.splat(color, 0, 1.0f));    // a float into a colour
    CHECK_FALSE(f.services.splat(depth, 0, Rgb(1)));  // a colour into a float
    CHECK_FALSE(f.services.splat(index, 0, 1.0f));    // ids cannot be splatted
    CHECK_FALSE(f.services.write(depth, 0, std::int32_t{1}));
    CHECK_FALSE(f.services.write(index, 0, 1.0f));
    CHECK_FALSE(f.services.write(color, 4, Rgb(1)));  // rows 0 to 3 exist
    CHECK_FALSE(f.services.write(color, -1, Rgb(1)));
    CHECK_FALSE(f.services.write_distance(4, 1.0f));
    CHECK_FALSE(f.services.write_opacity(-1, Rgb(1)));
    const std::vector<std::uint64_t> expected{3, 2, 2, 0, 4};
    for (std::size_t i = 0; i < expected.size(); ++i) CHECK(f.services.refusals()[i].total() == expected[i]);
    for (ChannelId id = 0; id < 4; ++id) CHECK_FALSE(f.table.touched(id));
}

TEST_CASE("each channel that refused calls has one warning with counts and reasons", "[display_services][law7]") {
    Fixture f;
    CHECK(refusal_warnings(f.channels, f.services.refusals()).empty());
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (int i = 0; i < 3; ++i) f.services.splat(color, 0, 1.0f);
    f.services.splat(color, 0, Rgb(nan));
    f.services.write(color, 7, Rgb(1));
    f.services.write(depth, 0, nan);
    f.services.splat(invalid_channel, 0, 1.0f);
    f.services.splat(99, 0, 1.0f);
    RefusalCounts sum;
    for (const RefusalCounts& each : f.services.refusals()) sum.add(each);
    CHECK(sum.by == std::array<std::uint64_t, refusal_kinds>{1, 1, 3, 2, 0, 0});
    CHECK(sum.of(Refusal::wrong_type) == 3);
    CHECK(refusal_warnings(f.channels, f.services.refusals()) ==
          std::vector<std::string>{
              "channel 'color' refused 5 calls: 1 to rows outside the batch, 3 whose "
              "type differs from the channel's type rgb, 1 with values that are not finite or out of range",
              "channel 'depth' refused 1 call: 1 with values that are not finite or out of range",
              "the display services refused 1 call: 1 with ids that are not channels"});
}

TEST_CASE("a batch of values is written like single values: valid ones are stored, invalid ones are counted",
          "[display_services][law7]") {
    Fixture f;
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const std::vector<std::int32_t> rows{0, 2, 9, -1, 3};
    const std::vector<float> reals{1, 2, 3, 4, nan};
    CHECK_FALSE(f.services.write(depth, rows, std::span<const float>(reals)));
    CHECK(f.values(depth, 0) == std::vector<double>{1});
    CHECK(f.values(depth, 2) == std::vector<double>{2});
    CHECK_FALSE(f.table.written(depth, 3));
    CHECK(f.services.refusals()[depth].total() == 3);
    const std::vector<Rgb> colors{Rgb(1, 2, 3), Rgb(4, 5, 6)};
    CHECK(f.services.write(color, std::span(rows).first(2), std::span<const Rgb>(colors)));
    CHECK(f.values(color, 2) == std::vector<double>{4, 5, 6});
    CHECK(f.table.row_state(color, 2) == SampleTable::RowState::written);
    const std::vector<std::int32_t> ids{7, 8};
    CHECK(f.services.write(index, std::span(rows).first(2), std::span<const std::int32_t>(ids)));
    CHECK(f.values(index, 0) == std::vector<double>{7});
    CHECK_FALSE(f.services.write(color, rows, std::span<const float>(reals)));
    CHECK(f.services.refusals()[color].total() == 5);
    CHECK_FALSE(f.services.write(77, rows, std::span<const float>(reals)));
    CHECK(f.services.refusals().back().total() == 5);
}

TEST_CASE("triples in columns are written like triples", "[display_services][law6][law7]") {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const std::vector<float> x{1, 4, 7}, y{2, 5, 8}, z{3, 6, 9}, bad{3, nan, 9};
    const auto write = [&](Fixture& f, ChannelId id, const std::vector<std::int32_t>& rows,
                           const std::vector<float>& third) {
        return f.services.write(id, rows, DisplayServices::Columns{x.data(), y.data(), third.data()});
    };
    Fixture together, apart, refused;
    CHECK(write(together, color, {1, 2, 3}, z));
    CHECK(together.values(color, 3) == std::vector<double>{7, 8, 9});
    CHECK(together.table.row_state(color, 2) == SampleTable::RowState::written);
    CHECK_FALSE(together.table.written(color, 0));
    CHECK_FALSE(write(apart, color, {3, 0, 9}, z));  // out of order, with one invalid row
    CHECK(apart.values(color, 3) == std::vector<double>{1, 2, 3});
    CHECK(apart.values(color, 0) == std::vector<double>{4, 5, 6});
    CHECK(apart.services.refusals()[color].of(Refusal::unknown_row) == 1);
    CHECK_FALSE(write(refused, color, {1, 2, 3}, bad));
    CHECK(refused.values(color, 1) == std::vector<double>{1, 2, 3});
    CHECK(refused.values(color, 3) == std::vector<double>{7, 8, 9});
    CHECK_FALSE(refused.table.written(color, 2));
    CHECK(refused.services.refusals()[color].of(Refusal::bad_value) == 1);
    CHECK(refused.table.invalid_count(2) == 1);
    CHECK_FALSE(write(refused, depth, {1, 2, 3}, z));
    CHECK(refused.services.refusals()[depth].of(Refusal::wrong_type) == 3);
    CHECK_FALSE(write(refused, 77, {1, 2, 3}, z));
    CHECK(refused.services.refusals().back().of(Refusal::unknown_channel) == 3);
    CHECK(write(refused, color, {}, z));
}

TEST_CASE("consecutive rows are written together with the same result as one by one", "[display_services][law6]") {
    const auto channels = four_channels();
    constexpr int capacity = 40;
    const float nan = std::numeric_limits<float>::quiet_NaN(), infinite = std::numeric_limits<float>::infinity();
    for (const std::size_t count : {1u, 2u, 3u, 7u, 16u, 37u})  // whole vectors of values, and remainders
        for (const int bad : {-1, 0, static_cast<int>(count) / 2, static_cast<int>(count) - 1}) {
            CAPTURE(count, bad);
            std::vector<std::int32_t> rows(count);
            std::iota(rows.begin(), rows.end(), 2);
            std::vector<Rgb> colors(count);
            std::vector<float> reals(count);
            for (std::size_t i = 0; i < count; ++i) {
                reals[i] = 0.5f + static_cast<float>(i);
                colors[i] = Rgb(reals[i], -reals[i], 1 / reals[i]);
            }
            if (bad >= 0) {
                reals[static_cast<std::size_t>(bad)] = nan;
                colors[static_cast<std::size_t>(bad)][bad % 3] = infinite;
            }
            SampleTable at_once(channels, capacity), one_by_one(channels, capacity);
            std::vector<RefusalCounts> refusals;
            for (SampleTable* table : {&at_once, &one_by_one}) {
                table->begin(std::vector<CameraRow>(capacity));
                DisplayServices services(*table);
                for (const std::int32_t row : rows)
                    services.write(depth, row, -1.0f);  // an invalid value leaves this one unchanged
                bool all = true;
                if (table == &at_once) {
                    all &= services.write(depth, rows, std::span<const float>(reals));
                    all &= services.write(color, rows, std::span<const Rgb>(colors));
                    all &= services.write(index, rows, std::span<const std::int32_t>(rows));
                } else {
                    for (std::size_t i = 0; i < count; ++i) {
                        all &= services.write(depth, rows[i], reals[i]);
                        all &= services.write(color, rows[i], colors[i]);
                        all &= services.write(index, rows[i], rows[i]);
                    }
                }
                CHECK(all == (bad < 0));
                refusals.insert(refusals.end(), services.refusals().begin(), services.refusals().end());
            }
            for (const auto& [id, components] : {std::pair(depth, 1), std::pair(color, 3), std::pair(index, 1)}) {
                CHECK(
                    std::equal(at_once.values(id), at_once.values(id) + capacity * components, one_by_one.values(id)));
                for (int row = 0; row < capacity; ++row)
                    CHECK(at_once.row_state(id, row) == one_by_one.row_state(id, row));
            }
            const auto half = refusals.begin() + static_cast<std::ptrdiff_t>(refusals.size() / 2);
            CHECK(std::equal(refusals.begin(), half, half));
            CHECK(at_once.invalid_total() == one_by_one.invalid_total());
        }
    // Rows beyond the last one are not mistaken for others.
    Fixture f;
    const std::vector<std::int32_t> rows{f.table.row_count() - 1, f.table.row_count()};
    CHECK_FALSE(f.services.write(index, rows, std::span<const std::int32_t>(rows)));
    CHECK(f.services.refusals()[index].of(Refusal::unknown_row) == 1);
    CHECK(f.values(index, rows[0]) == std::vector<double>{static_cast<double>(rows[0])});
}

TEST_CASE("values that are not finite are refused and counted", "[display_services][law6]") {
    Fixture f;
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    CHECK_FALSE(f.services.splat(color, 0, Rgb(0, nan, 0)));
    CHECK_FALSE(f.services.splat(light, 0, Rgb(inf, 0, 0)));
    CHECK_FALSE(f.services.write(depth, 0, inf));
    CHECK_FALSE(f.services.write_distance(0, nan));
    CHECK(f.services.add_sample(0, {nan, RgbD(1), false}) == -1);
    CHECK(f.services.refusals()[color].total() == 1);
    CHECK(f.services.refusals()[light].total() == 1);
    CHECK(f.services.refusals()[depth].total() == 1);
    CHECK(f.services.refusals()[4].total() == 2);
}

TEST_CASE("splat_multi uses the valid ids and reports the invalid one", "[display_services]") {
    Fixture f;
    const std::array<ChannelId, 4> ids{color, invalid_channel, light, 99};
    CHECK_FALSE(f.services.splat_multi(ids, 2, Rgb(1, 2, 3)));
    CHECK(f.values(color, 2) == std::vector<double>{1, 2, 3});
    CHECK(f.values(light, 2) == std::vector<double>{1, 2, 3});
    CHECK(f.services.refusals()[4].total() == 1);
    const std::array<ChannelId, 2> good{color, light};
    CHECK(f.services.splat_multi(good, 2, Rgb(1, 1, 1)));
}

TEST_CASE("the channel list has every id, style, type and name", "[display_services]") {
    Fixture f;
    const auto list = f.services.get_display_channels();
    REQUIRE(list.size() == 4);
    for (std::size_t i = 0; i < 4; ++i) {
        CHECK(list[i].id == static_cast<ChannelId>(i));
        CHECK(list[i].style == f.channels[i].style);
        CHECK(list[i].type == f.channels[i].type);
        CHECK(list[i].name == f.channels[i].name);
    }
}

TEST_CASE("added samples keep their camera ray, depth and opacity, and the table grows for them",
          "[display_services]") {
    Fixture f;
    const int first = f.services.add_sample(2, {3.0f, RgbD(0.25, 0.5, 0.75), true});
    CHECK(first == 4);
    CHECK(f.table.original(first) == 2);
    CHECK(f.table.camera_row(first).sample == 2);
    CHECK(f.table.depth[4] == 3.0f);
    CHECK(f.table.opacity[4] == RgbD(0.25, 0.5, 0.75));
    CHECK(f.table.is_volume[4] == 1);
    const int second = f.services.add_sample(first, {5.0f, RgbD(1), false});  // based on an added row, with the same
                                                                              // camera ray
    CHECK(f.table.original(second) == 2);
    CHECK(f.services.splat(color, second, Rgb(1)));
    CHECK(f.services.write(depth, second, 6.0f));
    // There is room for 8 rows at first. Growing moves the values of rows; new rows have the miss value.
    for (int i = 0; i < 100; ++i) CHECK(f.services.add_sample(0, {}) == 6 + i);
    CHECK(f.values(depth, second) == std::vector<double>{6});
    CHECK(f.values(color, second) == std::vector<double>{1, 1, 1});
    CHECK(f.values(depth, 105) == std::vector<double>{std::numeric_limits<double>::infinity()});
    CHECK_FALSE(f.table.written(depth, 105));
    CHECK(f.table.opacity[4] == RgbD(0.25, 0.5, 0.75));
    CHECK(f.table.last_row_of(0) == 105);
    CHECK(f.services.refusals()[4].total() == 0);
    f.table.begin(test::pixel_rows(0, 0, 4, 4));
    CHECK(f.table.row_count() == 4);
    CHECK_FALSE(f.services.splat(color, second, Rgb(1)));  // the batch of this row has ended
}

TEST_CASE("opacity is written or added, and a new batch starts clear", "[display_services]") {
    Fixture f;
    CHECK(f.services.write_opacity(0, Rgb(0.5f)));
    CHECK(f.services.splat_opacity(0, Rgb(0.25f)));
    CHECK(f.table.opacity[0] == RgbD(0.75));
    CHECK(f.services.write_opacity(0, 0.25f));  // a float means three equal colours
    CHECK(f.services.splat_opacity(0, 0.5f));
    CHECK(f.table.opacity[0] == RgbD(0.75));
    CHECK_FALSE(f.services.write_opacity(0, std::numeric_limits<float>::infinity()));
    CHECK_FALSE(f.services.splat_opacity(9, 0.5f));
    CHECK(f.table.opacity[0] == RgbD(0.75));
    CHECK(f.services.write_distance(0, 2.0f, true));
    CHECK(f.services.write(depth, 0, 2.0f));
    CHECK(f.services.write(color, 3, Rgb(1)));
    f.table.begin(test::pixel_rows(0, 0, 4, 4));
    CHECK(f.table.opacity[0] == RgbD(0));
    CHECK(f.table.depth[0] == std::numeric_limits<float>::infinity());
    CHECK(f.table.is_volume[0] == 0);
    CHECK(f.values(depth, 0) == std::vector<double>{std::numeric_limits<double>::infinity()});
    CHECK(f.values(color, 3) == std::vector<double>{0, 0, 0});
    CHECK_FALSE(f.table.written(depth, 0));
    CHECK_FALSE(f.table.touched(color));
}

TEST_CASE("a discarded iteration leaves no trace", "[display_services]") {
    Fixture f;
    FrameBuffer buffer({2, 2}, f.channels);
    f.services.splat(color, 0, Rgb(3));
    f.services.write_opacity(0, Rgb(1));
    f.services.discard_iteration();
    CHECK(f.table.discarded());
    buffer.accumulate(f.table);
    CHECK(buffer.sample_count(0, 0) == 0);
    f.table.begin(test::pixel_rows(0, 0, 0, 4));
    CHECK_FALSE(f.table.discarded());
    f.services.splat(color, 0, Rgb(4));
    buffer.accumulate(f.table);
    CHECK(buffer.sample_count(0, 0) == 4);
    CHECK(buffer.resolve(color)[0] == 1.0);
}

}  // namespace
}  // namespace raylex::display
