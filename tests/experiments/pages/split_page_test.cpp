// The layers of an image in a page: values, shares, folded layers, and the size of the page.
#include <catch2/catch.hpp>

#include <Imath/half.h>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "experiments/job/text/json.h"
#include "experiments/report/page_layers.h"
#include "experiments/report/pixel_data.h"
#include "tests/experiments/pages/unpacked.h"

using namespace raylex::experiments;
namespace display = raylex::display;
using raylex::experiments::Json;
using raylex::experiments::parse_json;
using raylex::test::unpacked;

namespace {

std::vector<float> unpacked_halves(const std::string& text, std::size_t count) {
    const std::vector<unsigned char> bytes = unpacked(text, 2 * count);
    std::vector<float> values;
    unsigned high = 0;
    for (std::size_t i = 0; i < count; ++i) {
        high = (high + bytes[i]) & 255U;
        Imath::half value;
        value.setBits(static_cast<std::uint16_t>(high << 8U | bytes[count + i]));
        values.push_back(value);
    }
    return values;
}

/// Returns the text between two marks.
std::string between(const std::string& text, const std::string& before, const std::string& after) {
    const std::size_t from = text.find(before);
    REQUIRE(from != std::string::npos);
    const std::size_t start = from + before.size();
    return text.substr(start, text.find(after, start) - start);
}

display::ImageLayer layer(const std::string& name, const std::vector<std::string>& planes, std::size_t pixels,
                          float value) {
    display::ImageLayer made;
    made.name = name;
    for (const std::string& plane : planes)
        made.planes.push_back({plane, display::StoredType::single_float, std::vector<float>(pixels, value)});
    return made;
}

const std::vector<std::string> rgb{"R", "G", "B"};

/// 8 x 4 pixels: a beauty of 4, split into `lit` of 1 and `more` of 3; `dark` without light; ids and depths.
display::ExrImage image_of_layers() {
    display::ExrImage image;
    image.path = "made.exr";
    image.width = 8;
    image.height = 4;
    image.layers = {layer("", rgb, 32, 4),
                    layer("lit", rgb, 32, 1),
                    layer("more", rgb, 32, 3),
                    layer("dark", rgb, 32, 0),
                    layer("id", {"id"}, 32, 16777215.0F),
                    layer("z", {"Z"}, 32, 1e6F)};
    image.partitions = {{"all", "", {"lit", "more", "dark"}}};
    return image;
}

Json data_of(const std::string& html) {
    return parse_json(between(html, "<script type=\"application/json\" class=\"data\">", "</script>"));
}

std::string pixels_of(const std::string& html, const Json& layer) {
    return between(html, "id=\"" + layer["data"].get<std::string>() + "\">", "</script>");
}

}  // namespace

TEST_CASE("packed values unpack to half precision", "[report]") {
    const float infinity = std::numeric_limits<float>::infinity();
    const std::vector<float> values{0, 1, -2.5F, 0.1F, 65504, 1e6F, -infinity, infinity, std::nanf(""), 6e-8F};
    const std::vector<float> back = unpacked_halves(pack_halves(values), values.size());
    CHECK(back[0] == 0);
    CHECK(back[2] == -2.5F);
    CHECK(std::abs(back[3] / 0.1F - 1) <= std::exp2(-11));
    CHECK(back[5] == 65504);
    CHECK(back[6] == -infinity);
    CHECK(back[7] == infinity);
    CHECK(std::isnan(back[8]));
    CHECK(back[9] == std::exp2(-24.0F));
    const std::vector<float> whole{0, 1, 16777215, 4294967040.0F, -1, 4294967296.0F, std::nanf("")};
    const std::vector<unsigned char> bytes = unpacked(pack_integers(whole), 4 * whole.size());
    for (std::size_t i = 0; i < whole.size(); ++i) {
        std::uint64_t value = 0;
        for (std::size_t byte = 0; byte < 4; ++byte) value = value << 8U | bytes[byte * whole.size() + i];
        CHECK(value == (i < 4 ? static_cast<std::uint64_t>(whole[i]) : 0));
    }
}

TEST_CASE("the table of a view has the view's colours at its nodes", "[report]") {
    auto color = display::ColorManager::open();
    REQUIRE(color);
    const display::Chromaticities primaries{};
    auto packed = pack_view(*color, primaries, "", "");
    REQUIRE(packed);
    const std::vector<unsigned char> table = unpacked(*packed, view_nodes * view_nodes * view_nodes * 3);
    const auto node = [](std::size_t i) {
        return static_cast<float>(std::exp2(static_cast<double>(i) / 2 - 10) - std::exp2(-10));
    };
    CHECK(node(20) == Approx(1).epsilon(1e-3));
    const std::size_t red = 17, green = 9, blue = 22;  // red varies fastest
    auto shown = color->to_display(std::vector<float>{node(red), node(green), node(blue)}, primaries, "", "");
    REQUIRE(shown);
    for (std::size_t c = 0; c < 3; ++c)
        CHECK(table[((blue * view_nodes + green) * view_nodes + red) * 3 + c] == (*shown)[c]);
}

TEST_CASE("a page has the values and shares of every layer, and folds layers without light", "[report]") {
    auto color = display::ColorManager::open();
    REQUIRE(color);
    const PageOptions options;
    PageLayers layers(*color, options, 1'000'000);
    auto html = layers.html(image_of_layers());
    REQUIRE(html);
    CHECK(html->find("1 layer without light in this image") != std::string::npos);
    CHECK(html->find("data-name=\"dark\"") > html->find("<details><summary>1 layer"));
    const Json data = data_of(*html);
    CHECK(data["block"] == 1);
    REQUIRE(data["layers"].size() == 6);
    CHECK(data["layers"][0]["name"] == "beauty");
    CHECK(data["layers"][1]["share"] == 0.25);
    CHECK(data["layers"][2]["share"] == 0.75);
    CHECK(data["layers"][2]["whole"] == 0);
    CHECK(data["layers"][5]["empty"] == true);
    CHECK(data["layers"][5]["data"].is_null());
    CHECK(unpacked_halves(pixels_of(*html, data["layers"][2]), 32 * 3) == std::vector<float>(96, 3));
    for (const Json& each : data["layers"])
        if (each["name"] == "z") {
            CHECK(each["planes"] == Json{"Z"});
            const float value = unpacked_halves(pixels_of(*html, each), 32)[0] * each["scale"].get<float>();
            CHECK(value == Approx(1e6).epsilon(std::exp2(-11)));
        } else if (each["name"] == "id") {
            const std::vector<unsigned char> bytes = unpacked(pixels_of(*html, each), 32 * 4);
            CHECK(bytes[0] == 0);
            CHECK(bytes[32] == 255);
            CHECK(bytes[96] == 255);
        }
    CHECK(layers.view_scripts().find("id=\"view-0\"") != std::string::npos);
}

TEST_CASE("a page that would be too large has means over blocks", "[report]") {
    auto color = display::ColorManager::open();
    REQUIRE(color);
    display::ExrImage image = image_of_layers();
    for (display::ImagePlane& plane : image.layers[0].planes) plane.values[0] = 12;  // in the first block of four
    const PageOptions options;
    PageLayers layers(*color, options, 32 * 11 * 7 / 4 / 4);
    auto html = layers.html(image);
    REQUIRE(html);
    const Json data = data_of(*html);
    CHECK(data["block"] == 2);
    CHECK(data["width"] == 4);
    CHECK(data["height"] == 2);
    CHECK(unpacked_halves(pixels_of(*html, data["layers"][0]), 8 * 3)[0] == (12 + 3 * 4) / 4);
}

TEST_CASE("the page of a file without a layer that can be shown says so", "[report]") {
    auto color = display::ColorManager::open();
    REQUIRE(color);
    display::ExrImage image;
    image.path = "made.exr";
    image.width = image.height = 1;
    image.layers = {layer("odd", {"p", "q"}, 1, 1)};
    const PageOptions options;
    PageLayers layers(*color, options, 1'000'000);
    auto html = layers.html(image);
    REQUIRE(html);
    CHECK(html->find("No layer of this file can be shown") != std::string::npos);
}
