// Law 6, pixel by pixel: values refused as not finite are counted at their pixels, and the AOV invalidSamples shows the
// counts.
#include <limits>
#include <map>

#include <catch2/catch.hpp>

#include "display/buffer/frame_buffer/frame_buffer.h"
#include "geoaovs/geoaovs.h"
#include "tests/services/lpe_helpers.h"

namespace raylex::geoaovs {
namespace {

using namespace display;

constexpr float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
constexpr ChannelId beauty = 0, seen = 1, lit = 2, normal = 3, invalid = 4;

std::vector<ChannelDefinition> test_channels() {
    return {test::plain_channel("beauty", ChannelType::rgb), test::expression_channel("seen", "CL"),
            test::expression_channel("lit", "C<RD>L"), *channel_definition("Nn"),
            *channel_definition("invalidSamples")};
}

TEST_CASE("planted values that are not finite are counted only at their pixels and channels", "[invalid][law6]") {
    const std::vector<ChannelDefinition> channels = test_channels();
    const LpeSetup setup = test::build_setup(channels, beauty);
    const test::Classes classes(setup);
    const GeometricAovs aovs(channels);
    CHECK(aovs.wants_samples());
    FrameBuffer buffer({4, 1}, channels);
    SampleTable table(channels, 16);
    DisplayServices display(table);
    LpeServices lpe(setup, table, 1);
    // Per pixel: contributions of NaN, of infinity, and values of Nn, by sample.
    const std::array<double, 4> expected{0, 3, 0, 6};
    for (int x = 0; x < 4; ++x) {
        table.begin(test::pixel_rows(x, 0, 0, 8));
        for (int row = 0; row < 8; ++row) {
            Tracker direct = lpe.begin(row);
            lpe.move(direct, classes.light);
            lpe.contribute(Rgb(1.0f), Technique{}, direct);
            Tracker bounced = lpe.begin(row);
            lpe.move(bounced, classes.diffuse);
            lpe.move(bounced, classes.light);
            if (x == 1 && row < 2) lpe.contribute(Rgb(0.0f, nan, 0.0f), Technique{1, 2}, bounced);
            if (x == 1 && row == 7) lpe.contribute(Rgb(-inf), Technique{1, 2}, direct);
            if (x == 3 && row == 0) {
                lpe.contribute(Rgb(2 * setup.largest_contribution()), Technique{1, 2}, bounced);
                CHECK_FALSE(display.write(normal, row, Rgb(nan)));
                const std::vector<std::int32_t> rows{0, 5};
                CHECK_FALSE(display.write(normal, rows, std::vector<Rgb>{Rgb(inf), Rgb(0.0f)}));
                CHECK_FALSE(display.write_distance(row, nan));
                CHECK_FALSE(display.splat_opacity(row, Rgb(nan)));
                // On an extra row it counts for the camera ray.
                const int extra = display.add_sample(row, {2.0f, RgbD(0.5), false, 0});
                CHECK_FALSE(display.write(normal, extra, Rgb(nan)));
            }
        }
        aovs.write_samples(0, table, display);
        buffer.accumulate(table);
    }
    CHECK(buffer.resolve(invalid) == std::vector<double>(expected.begin(), expected.end()));
    CHECK(table.invalid_total() == 9);
    CHECK(table.invalid_by_channel()[beauty] == 4);
    CHECK(table.invalid_by_channel()[seen] == 1);
    CHECK(table.invalid_by_channel()[lit] == 3);
    CHECK(table.invalid_by_channel()[normal] == 3);
    REQUIRE(table.invalid_log().size() == 9);
    CHECK(table.invalid_log()[2].sample == 7);
    CHECK(table.invalid_log()[2].channel == invalid_channel);
    CHECK(table.invalid_log()[4].channel == normal);
    const std::vector<double> image = buffer.resolve(beauty);  // the valid values are all there
    for (const double v : image) CHECK(v == 1);
}

TEST_CASE("refused values of a discarded batch do not count, in the image or elsewhere", "[invalid][law6]") {
    const std::vector<ChannelDefinition> channels = test_channels();
    const GeometricAovs aovs(channels);
    FrameBuffer buffer({1, 1}, channels);
    SampleTable table(channels, 4);
    DisplayServices display(table);
    table.begin(test::pixel_rows(0, 0, 0, 1));
    display.write(normal, 0, Rgb(nan));
    display.discard_iteration();
    buffer.accumulate(table);
    table.begin(test::pixel_rows(0, 0, 0, 1));
    CHECK(table.invalid_count(0) == 0);
    aovs.write_samples(0, table, display);
    buffer.accumulate(table);
    CHECK(buffer.resolve(invalid)[0] == 0);
    CHECK(table.invalid_total() == 0);
}

}  // namespace
}  // namespace raylex::geoaovs
