// Display filters on resolved pixels.
#include "display/filters/display_filter.h"

#include <catch2/catch.hpp>

#include "display/buffer/frame_buffer/frame_buffer.h"
#include "display/services/object_request.h"
#include "tests/services/helpers.h"

namespace raylex::display {
namespace {

const SourceLocation where{"job.toml", 4, 2};
constexpr int picture_width = 3, picture_height = 2;

/// beauty = a + b, random; alpha 0.25; z.
struct Image {
    std::vector<ChannelDefinition> channels{test::expression_channel("beauty", "C.*"),
                                            test::expression_channel("a", "CDL"), test::expression_channel("b", "CSL"),
                                            test::plain_channel("z", ChannelType::real, FilterRule::zmin)};
    FrameBuffer buffer{{picture_width, picture_height}, channels};
    std::vector<std::unique_ptr<DisplayFilter>> filters;

    Image() {
        SampleTable table(channels, 8);
        test::Random random(8);
        for (int pixel = 0; pixel < picture_width * picture_height; ++pixel) {
            table.begin(test::pixel_rows(pixel % picture_width, pixel / picture_width, 0, 8));
            for (int i = 0; i < 24; ++i) {
                table.raw_values(1)[i] = random.uniform();
                table.raw_values(2)[i] = random.uniform();
                table.raw_values(0)[i] = table.raw_values(1)[i] + table.raw_values(2)[i];
            }
            for (ChannelId id = 0; id < 3; ++id) table.touch(id);
            for (int row = 0; row < 8; row += 4) table.opacity[static_cast<std::size_t>(row)] = RgbD(1.0);
            buffer.accumulate(table);
        }
    }
    std::string add(const std::string& text) {
        const auto request = parse_object_request(text, display_filter_registry(), "display filter", where);
        if (!request) return request.error().to_string();
        auto filter = make_display_filter(request->name, request->parameters, {channels, 0});
        if (!filter) return filter.error().to_string();
        filters.push_back(*std::move(filter));
        return {};
    }
    [[nodiscard]] FilteredImage seen() const { return {buffer, filters}; }
};

TEST_CASE("without filters an image is unchanged", "[display_filter]") {
    const Image image;
    for (ChannelId id = 0; id < 4; ++id) CHECK(image.seen().resolve(id) == image.buffer.resolve(id));
    CHECK(image.seen().resolve_alpha() == image.buffer.resolve_alpha());
    CHECK(image.seen().layout() == image.buffer.layout());
}

TEST_CASE("filters work in order, equally by region and on the whole, and do not change the frame buffer",
          "[display_filter]") {
    Image image;
    const std::vector<double> before = image.buffer.resolve(0);
    REQUIRE(image.add("background:color=1 2 4").empty());
    REQUIRE(image.add("grade:exposure=1").empty());
    const FilteredImage seen = image.seen();
    const std::vector<double> beauty = seen.resolve(0);
    for (std::size_t i = 0; i < before.size(); ++i)
        CHECK(beauty[i] == Approx(2 * (before[i] + 0.75 * std::exp2(i % 3))).epsilon(1e-14));
    for (const double a : seen.resolve_alpha()) CHECK(a == 1);
    CHECK(image.buffer.resolve(0) == before);
    const std::vector<double> corner = seen.resolve(0, {1, 1, 3, 2});
    CHECK(corner == std::vector<double>(beauty.begin() + 3 * 4, beauty.end()));
    CHECK(image.filters[0]->alters() == std::vector<ChannelId>{0});

    Image other;  // the opposite order
    REQUIRE(other.add("grade:exposure=1").empty());
    REQUIRE(other.add("background:color=1 2 4").empty());
    CHECK(other.seen().resolve(0)[0] == Approx(2 * before[0] + 0.75).epsilon(1e-14));
}

TEST_CASE("a grade of all light keeps the sum of resolved layers", "[display_filter][law1]") {
    Image image;
    REQUIRE(image.add("grade:gain=0.5 1 3,saturation=0.4").empty());
    CHECK(image.filters[0]->alters().empty());
    const FilteredImage seen = image.seen();
    const std::vector<double> whole = seen.resolve(0), a = seen.resolve(1), b = seen.resolve(2);
    CHECK(whole != image.buffer.resolve(0));
    for (std::size_t i = 0; i < whole.size(); ++i)
        CHECK(std::abs(a[i] + b[i] - whole[i]) <= 1e-12 * (a[i] + b[i] + whole[i]));
    CHECK(seen.resolve(3) == image.buffer.resolve(3));

    REQUIRE(image.add("grade:channels=z,gain=2,offset=1").empty());
    CHECK(image.filters[1]->alters() == std::vector<ChannelId>{3});
    CHECK(image.seen().resolve(3)[0] == 2 * image.buffer.resolve(3)[0] + 1);
}

TEST_CASE("display filters that cannot be made give errors with the expected values", "[display_filter][law7]") {
    Image image;
    CHECK(image.add("grad").find("did you mean 'grade'") != std::string::npos);
    CHECK(image.add("grade:offset=1").find("no longer sum") != std::string::npos);
    CHECK(image.add("background:colour=1").find("did you mean 'color'") != std::string::npos);
    CHECK(image.add("background:color=1 2").find("job.toml:4:2") != std::string::npos);
    CHECK_FALSE(make_display_filter("background", {}, {image.channels, invalid_channel}));
}

}  // namespace
}  // namespace raylex::display
