// What a rebuild lacks or counts twice, and the layers that explain it.
#include <catch2/catch.hpp>

#include <array>
#include <map>
#include <vector>

#include "display/output/comparison/comparison.h"
#include "display/output/splits/split_check.h"
#include "display/output/splits/split_sum.h"
#include "files.h"

using namespace raylex::test;
namespace display = raylex::display;

namespace {

using RebuildPixels = std::vector<std::array<float, 3>>;

/// 3 x 2 pixels: a beauty = a + b + emit, of which emit is 0 in the first two pixels.
display::ExrImage image_to_rebuild() {
    RebuildPixels beauty, a, b, emit;
    for (int i = 0; i < 6; ++i) {
        const auto x = static_cast<float>(i);
        a.push_back({1 + x, 2, 3});
        b.push_back({0.5F, 0.25F * x, 8});
        emit.push_back(i < 2 ? std::array<float, 3>{} : std::array<float, 3>{x, 0, 2 * x});
        beauty.emplace_back();
        for (std::size_t c = 0; c < 3; ++c) beauty.back()[c] = a.back()[c] + b.back()[c] + emit.back()[c];
    }
    return image_of(3, 2,
                    {color_layer("", beauty), color_layer("a", a), color_layer("b", b), color_layer("emit", emit)});
}

display::SplitResult rebuilt(const display::ExrImage& image, const std::string& sum) {
    auto result = display::check_split(image, "", {sum});
    if (!result) FAIL(result.error().to_string());
    return *std::move(result);
}

display::ExrImage rows_of(const display::ExrImage& image, int y0, int y1) {
    display::ExrImage part = image;
    part.height = y1 - y0;
    for (display::ImageLayer& layer : part.layers)
        for (display::ImagePlane& plane : layer.planes)
            plane.values =
                std::vector<float>(plane.values.begin() + y0 * image.width, plane.values.begin() + y1 * image.width);
    return part;
}

}  // namespace

TEST_CASE("a rebuild names the layer that it lacks, and the one that it counts twice", "[display][verify]") {
    const display::ExrImage image = image_to_rebuild();
    const display::Rebuild whole = rebuilt(image, "a,b,emit").rebuild;
    CHECK(whole.light.empty());
    CHECK(whole.unassigned.pixels + whole.doubled.pixels == 0);
    CHECK(whole.unassigned.cause().empty());

    const display::Rebuild lacks = rebuilt(image, "a,b").rebuild;
    CHECK(lacks.unassigned.pixels == 4);
    CHECK(lacks.unassigned.light == 3 * (2 + 3 + 4 + 5));
    CHECK(lacks.unassigned.largest == 10);
    CHECK((lacks.unassigned.x == 2 && lacks.unassigned.y == 1));
    CHECK(lacks.unassigned.cause() == "emit");
    CHECK(lacks.doubled.pixels == 0);
    CHECK(lacks.light[3 * 5 + 2] == 10);
    CHECK(lacks.light[3 * 1 + 2] == 0);

    const display::Rebuild twice = rebuilt(image, "a+a,b,emit").rebuild;
    CHECK(twice.doubled.pixels == 6);
    CHECK(twice.doubled.cause() == "a");
    CHECK(twice.unassigned.pixels == 0);
    CHECK(twice.light[0] == -1);
    // Two layers are missing: no single one is the cause.
    CHECK(rebuilt(image, "b").rebuild.unassigned.cause().empty());
    CHECK(rebuilt(image, "a,b,b-a").rebuild.unassigned.cause().empty());
}

TEST_CASE("a rebuild counts negative values of each layer, and what a colour of 0 loses", "[display][verify]") {
    const RebuildPixels one{{1, 1, 1}, {2, 2, 2}, {4, 4, 4}};
    const RebuildPixels color{{0.5F, 0.5F, 0.5F}, {0.5F, 0, 0.5F}, {0, 0, 0}};
    const RebuildPixels beauty{{0.5F, 0.5F, 0.5F}, {1, 3, 1}, {0, 0, 0}};
    const auto image = [&](const char* direct, const char* factor) {
        return image_of(3, 1, {color_layer("", beauty), color_layer(direct, one), color_layer(factor, color)});
    };
    for (const char* sum : {"dir*col", "(dir)*col", "col*(dir+dir-dir)"}) {
        CAPTURE(sum);
        const std::map<std::string, double> lost = rebuilt(image("dir", "col"), sum).rebuild.lost;
        REQUIRE(lost.size() == 1);
        CHECK(lost.begin()->first == "col");
        CHECK(lost.at("col") == 3);  // the third pixel is black in the beauty, too
    }
    const display::ExrImage dark =
        image_of(2, 1,
                 {color_layer("", {{0, 0, 0}, {0, 0, 0}}), color_layer("a", {{-1, 0, -3}, {1, 0, 0}}),
                  color_layer("b", {{1, 0, 3}, {-1, 0, -2}}), color_layer("c", {{0, 0, 0}, {0, 0, 2}})});
    const display::SplitResult negative = rebuilt(dark, "a,b,c");
    CHECK(negative.holds);
    CHECK(negative.negative.pixels == 2);
    REQUIRE(negative.rebuild.negative.size() == 2);
    CHECK(negative.rebuild.negative.at("a").pixels == 1);
    CHECK(negative.rebuild.negative.at("a").lowest == -3);
    CHECK(negative.rebuild.negative.at("b").lowest == -2);
    CHECK(negative.rebuild.negative.at("b").x == 1);
}

TEST_CASE("a rebuild in bands of rows is that of the whole image", "[display][verify][bands]") {
    display::ExrImage image = image_to_rebuild();
    image.layers[2].planes[1].values[4] = -1;
    for (const char* sum : {"a,b", "a+a,b,emit", "a,b,emit", "a*b,emit"}) {
        CAPTURE(sum);
        const display::SplitResult whole = rebuilt(image, sum);
        display::SplitResult bands = rebuilt(rows_of(image, 0, 1), sum);
        display::add_rows(bands, rebuilt(rows_of(image, 1, 2), sum), 1);
        const auto same = [](const display::LightDifference& a, const display::LightDifference& b) {
            CHECK(a.light == Approx(b.light));
            CHECK((a.pixels == b.pixels && a.largest == b.largest && a.x == b.x && a.y == b.y));
            CHECK(a.cause() == b.cause());
        };
        same(whole.rebuild.unassigned, bands.rebuild.unassigned);
        same(whole.rebuild.doubled, bands.rebuild.doubled);
        CHECK(whole.rebuild.light == bands.rebuild.light);
        CHECK(whole.rebuild.whole == Approx(bands.rebuild.whole));
        REQUIRE(whole.rebuild.negative.size() == bands.rebuild.negative.size());
        for (const auto& [layer, negative] : whole.rebuild.negative) {
            CHECK(negative.pixels == bands.rebuild.negative[layer].pixels);
            CHECK(negative.y == bands.rebuild.negative[layer].y);
        }
        for (const auto& [factor, light] : whole.rebuild.lost) CHECK(light == Approx(bands.rebuild.lost[factor]));
    }
}

TEST_CASE("the written light completes the sum", "[display][verify]") {
    const Folder folder;
    const display::ExrImage image = image_to_rebuild();
    const display::SplitResult result = rebuilt(image, "a+a,b");
    REQUIRE(display::write_unassigned_exr(folder.path("u.exr"), result, image).ok());
    const auto read = display::read_exr(folder.path("u.exr"));
    REQUIRE(read.ok());
    for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t i = 0; i < 6; ++i) {
            const auto value = [&](const display::ExrImage& from, const char* name) {
                return from.layer(name)->triple()[c]->values[i];
            };
            const float sum = 2 * value(image, "a") + value(image, "b");
            const float unassigned = value(*read, "unassigned"), twice = value(*read, "counted_twice");
            CHECK(sum + unassigned - twice == value(image, ""));
            CHECK((unassigned >= 0 && twice >= 0));
        }
}
