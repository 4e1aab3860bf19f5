#include "display/output/splits/split_check.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include <png.h>

#include "files.h"

using namespace raylex::test;
using raylex::display::check_declared_splits;
using raylex::display::check_split;
using raylex::display::glob_match;
using raylex::display::StoredType;

namespace {

constexpr float ulp = 0x1p-23f;  // spacing of floats in [1, 2)

raylex::display::SplitResult result_of(const raylex::display::ExrImage& image, const std::vector<std::string>& globs,
                                       const std::string& of = "") {
    auto result = check_split(image, of, globs);
    if (!result) FAIL(result.error().message);
    return *result;
}

raylex::display::ExrImage one_pixel(float whole, std::vector<float> layers,
                                    StoredType type = StoredType::single_float) {
    std::vector<raylex::display::ImageLayer> all{color_layer("", {{whole, whole, whole}}, type)};
    for (std::size_t i = 0; i < layers.size(); ++i)
        all.push_back(color_layer("part" + std::to_string(i), {{layers[i], layers[i], layers[i]}}, type));
    return image_of(1, 1, std::move(all));
}

}  // namespace

TEST_CASE("globs match as in a shell", "[display][verify]") {
    CHECK(glob_match("diffuse_*", "diffuse_key"));
    CHECK(glob_match("diffuse_*", "diffuse_"));
    CHECK(!glob_match("diffuse_*", "diffuse"));
    CHECK(glob_match("*", ""));
    CHECK(glob_match("*", "anything.at all"));
    CHECK(glob_match("?", "a"));
    CHECK(!glob_match("?", ""));
    CHECK(glob_match("a*b*c", "axxbyybzzc"));
    CHECK(!glob_match("a*b*c", "axxbyybzz"));
    CHECK(glob_match("*.Diff*", "ViewLayer.DiffDir"));
    CHECK(!glob_match("Diff", "diff"));
    CHECK(glob_match("", ""));
    CHECK(!glob_match("", "a"));
    // Many stars over a long name must not take exponential time.
    CHECK(!glob_match("*a*a*a*a*a*a*a*a*a*a*a*a*b", std::string(5000, 'a')));
}

TEST_CASE("a split whose layers sum to beauty holds", "[display][verify][law1]") {
    auto image = image_of(
        2, 1,
        {color_layer("", {{1.0f, 0.5f, 0.25f}, {0, 0, 0}}), color_layer("diffuse", {{0.75f, 0.5f, -0.25f}, {0, 0, 0}}),
         color_layer("specular", {{0.25f, 0.0f, 0.5f}, {0, 0, 0}})});
    const auto result = result_of(image, {"diffuse", "specular"});
    CHECK(result.holds);
    CHECK(result.largest_absolute == 0);
    CHECK(result.largest_relative == 0);
    CHECK(result.bound == std::ldexp(1.0, -23) + std::ldexp(1.0, -24));  // plus one addition by another writer
    image.attributes["lpe/diffuse"] = "CDL";                             // raylex, whose sums are exact
    CHECK(result_of(image, {"diffuse", "specular"}).bound == std::ldexp(1.0, -23));
    CHECK(result.of == "beauty");
    CHECK(result.layers == std::vector<std::string>{"diffuse", "specular"});
    CHECK(result.residual == std::vector<float>{0, 0});
}

TEST_CASE("the bound holds exactly, and not one rounding step further", "[display][verify][law1]") {
    // sum = 1 + 2^-22 and of = 1: the difference is 2^-22, the scale 2 + 2^-22, so the bound 2^-22 + 2^-45 holds.
    CHECK(result_of(one_pixel(1.0f, {1.0f + 2 * ulp}), {"part*"}).holds);
    // One step more: difference 3 x 2^-23 against (2 + 3 x 2^-23) x 2^-23.
    const auto beyond = result_of(one_pixel(1.0f, {1.0f + 3 * ulp}), {"part*"});
    CHECK(!beyond.holds);
    CHECK(beyond.exceeding == 1);
    CHECK(beyond.largest_absolute == 3 * std::ldexp(1.0, -23));
    CHECK(beyond.largest_relative == Approx(1.5 * std::ldexp(1.0, -23)).epsilon(1e-6));  // scale 2 + 3 ulp
    // Exactly on the bound: layers 2^23 and 1 against 2^23 - 1; difference 2, scale 2^24. 2 = 2^-23 x 2^24.
    CHECK(result_of(one_pixel(0x1p23f - 1, {0x1p23f, 1.0f}), {"part*"}).holds);
    CHECK(result_of(one_pixel(0x1p23f - 1, {0x1p23f, 1.0f}), {"part*"}).largest_relative == std::ldexp(1.0, -23));
    // Cancelling layers increase the scale, not the difference.
    CHECK(result_of(one_pixel(1.0f, {1000.0f + 0x1p-13f, -999.0f}), {"part*"}).holds);  // 2^-13 <= 2000 x 2^-23
    CHECK(!result_of(one_pixel(1.0f, {1000.0f + 0x1p-11f, -999.0f}), {"part*"}).holds);
}

TEST_CASE("half files are checked with half's rounding, each layer by its own type", "[display][verify][law1]") {
    CHECK(result_of(one_pixel(1.0f, {1.0f + 0x1p-9f}, StoredType::half_float), {"part*"}).bound ==
          std::ldexp(1.0, -10));
    CHECK(result_of(one_pixel(1.0f, {1.0f + 0x1p-9f}, StoredType::half_float), {"part*"}).holds);
    CHECK(!result_of(one_pixel(1.0f, {1.0f + 3 * 0x1p-10f}, StoredType::half_float), {"part*"}).holds);
    auto mixed = image_of(
        1, 1, {color_layer("", {{1, 1, 1}}), color_layer("a", {{1.0f + 0x1p-9f, 1, 1}}, StoredType::half_float)});
    CHECK(result_of(mixed, {"a"}).bound == std::ldexp(1.0, -10));
    CHECK(!result_of(mixed, {"a"}).holds);  // the whole is a float: only the layer's half can be off, by one step
    mixed.layers[1].planes[0].values[0] = 1.0f + 0x1p-10f;
    CHECK(result_of(mixed, {"a"}).holds);
}

TEST_CASE("a split rounded to half holds however dark it is", "[display][verify][law1]") {
    // Below 2^-14 halves are evenly spaced, so the relative error of correct rounding grows without limit.
    for (float dark = 1.0f; dark > 1e-9f; dark *= 0.37f) {
        const float a = 0.3f * dark, b = 0.6f * dark, c = 0.1f * dark;
        const auto image = one_pixel(half(a + b + c), {half(a), half(b), half(c)}, StoredType::half_float);
        CAPTURE(dark);
        CHECK(result_of(image, {"part*"}).holds);
        CHECK(result_of(image, {"part*"}).largest_relative <= result_of(image, {"part*"}).bound);
    }
    // A missing layer is detected if it is above that spacing.
    CHECK(!result_of(one_pixel(half(1e-5f), {half(4e-6f), half(4e-6f)}, StoredType::half_float), {"part*"}).holds);
}

TEST_CASE("the largest absolute and relative errors are reported with their pixels", "[display][verify]") {
    std::vector<std::array<float, 3>> whole(6, {1, 1, 1}), layer = whole;
    whole[4] = {100, 1, 1};
    layer[4] = {101, 1, 1};   // absolute 1, relative 1 / 201
    layer[2] = {1, 1, 1.5f};  // absolute 0.5, relative 0.2
    const auto result = result_of(image_of(3, 2, {color_layer("", whole), color_layer("a", layer)}), {"a"});
    CHECK(!result.holds);
    CHECK(result.largest_absolute == 1.0);
    CHECK(result.absolute_x == 1);
    CHECK(result.absolute_y == 1);
    CHECK(result.largest_relative == Approx(0.2));
    CHECK(result.relative_x == 2);
    CHECK(result.relative_y == 0);
    CHECK(result.exceeding == 2);
    CHECK(result.residual[2] == Approx(0.2f));
    CHECK(result.residual[4] == Approx(1.0f / 201));
    CHECK(result.residual[0] == 0);
}

TEST_CASE("values that are not finite fail a split and are counted per pixel", "[display][verify][law6]") {
    constexpr float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    auto image = image_of(3, 1,
                          {color_layer("", {{1, 1, 1}, {inf, 1, 1}, {1, 1, 1}}),
                           color_layer("a", {{nan, nan, 1}, {inf, 1, 1}, {1, 1, 1}})});
    const auto result = result_of(image, {"a"});
    CHECK(!result.holds);
    CHECK(result.non_finite == 2);
    image.layers[1].planes[0].values[0] = 1;
    CHECK(result_of(image, {"a"}).non_finite_x == 0);  // its G is not finite
    image.layers[1].planes[1].values[0] = 1;
    CHECK(result_of(image, {"a"}).non_finite_x == 1);
    CHECK(result.exceeding == 0);
    CHECK(std::isinf(result.residual[0]));
    CHECK(result.residual[2] == 0);
}

TEST_CASE("layers are chosen once each, never the sum itself", "[display][verify]") {
    auto image = one_pixel(3.0f, {1.0f, 2.0f});
    image.layers.push_back(color_layer("other", {{7, 7, 7}}));
    CHECK(result_of(image, {"part0", "part*", "part?"}).layers == std::vector<std::string>{"part0", "part1"});
    CHECK(result_of(image, {"part*"}, "beauty").holds);
    image.layers.pop_back();
    CHECK(result_of(image, {"*"}).holds);  // all layers except the nameless one
    CHECK(result_of(one_pixel(1.0f, {1.0f}), {"*"}, "part0").layers == std::vector<std::string>{"beauty"});
    CHECK(!check_split(image, "part0", {"part0"}).ok());
}

TEST_CASE("unknown layers, ids and empty sums get errors with near misses", "[display][verify][law7]") {
    auto image = one_pixel(3.0f, {1.0f, 2.0f});
    const auto message = [&image](const std::string& of, const std::vector<std::string>& globs) {
        const auto result = check_split(image, of, globs);
        REQUIRE(!result.ok());
        CHECK(result.error().to_string().find("constructed.exr") != std::string::npos);
        return result.error().message + " " + result.error().hint;
    };
    CHECK(message("", {"prat1"}).find("did you mean 'part1'") != std::string::npos);
    CHECK(message("", {"part0", "zzz*"}).find("zzz*") != std::string::npos);
    CHECK(message("", {"zzz"}).find("part0, part1") != std::string::npos);
    CHECK(message("bety", {"part*"}).find("no layer 'bety'") != std::string::npos);
    CHECK(message("", {}).find("at least one") != std::string::npos);
    image.layers.push_back({"id", "id", {{"id", StoredType::unsigned_int, {1}}}});
    CHECK(message("", {"id"}).find("unsigned integers") != std::string::npos);
    image.layers.push_back({"uv", "uv", {{"U", StoredType::single_float, {1}}, {"V", StoredType::single_float, {1}}}});
    CHECK(message("", {"uv"}).find("U, V") != std::string::npos);
}

TEST_CASE("the whole image is found by the names of renderers, but a layer's own name comes first",
          "[display][verify]") {
    const auto rgb = [](const std::string& name, float value) { return color_layer(name, {{value, value, value}}); };
    const auto image = image_of(1, 1, {rgb("", 3.0f), rgb("beauty", 2.0f), rgb("x", 1.0f), rgb("y", 1.0f)});
    CHECK(result_of(image, {"x", "y"}, "beauty").holds);
    CHECK(result_of(image, {"x", "beauty"}, "").holds);
    CHECK(result_of(image, {"x", "beauty"}, "RGBA").holds);
    // Every command finds the beauty of another renderer by its usual name, and the result contains the layer's name.
    const auto blender = image_of(1, 1, {rgb("ViewLayer.Combined", 1.0f), rgb("ViewLayer.DiffDir", 1.0f)});
    for (const char* name : {"", "beauty"}) {
        CHECK(result_of(blender, {"ViewLayer.DiffDir"}, name).of == "ViewLayer.Combined");
        CHECK((*blender.require_layer(name))->name == "ViewLayer.Combined");
    }
    CHECK_FALSE(image_of(1, 1, {rgb("x", 1.0f)}).require_layer("beauty"));
    // The name of a part denotes its layer; for a cryptomatte, the layer of the first ranks.
    auto mattes = image_of(1, 1, {rgb("", 1.0f), rgb("CryptoObject00", 1.0f), rgb("CryptoObject01", 1.0f)});
    mattes.layers[1].part = mattes.layers[2].part = "CryptoObject";
    CHECK((*mattes.require_layer("CryptoObject"))->name == "CryptoObject00");
    mattes.layers[2].name = "CryptoObject.more";
    CHECK_FALSE(mattes.require_layer("CryptoObject"));
    CHECK(result_of(image_of(1, 1, {rgb("x", 1.0f), rgb("", 1.0f)}), {"beauty"}, "x").holds);
}

TEST_CASE("single planes and vectors can be summed, too", "[display][verify]") {
    auto image = image_of(1, 1,
                          {{"depth", "", {{"Y", StoredType::single_float, {3}}}},
                           {"a", "", {{"Y", StoredType::single_float, {1}}}},
                           {"b", "", {{"Y", StoredType::single_float, {2}}, {"A", StoredType::single_float, {9}}}}});
    CHECK(result_of(image, {"a", "b"}, "depth").holds);
    CHECK(!result_of(image, {"a"}, "depth").holds);
}

TEST_CASE("declared partitions are checked one by one", "[display][verify][law1]") {
    auto image = one_pixel(3.0f, {1.0f, 2.0f});
    CHECK(check_declared_splits(image)->empty());
    image.partitions = {{"auto", "", {"part0", "part1"}}, {"wrong", "beauty", {"part0"}}};
    const auto results = check_declared_splits(image);
    REQUIRE(results.ok());
    REQUIRE(results->size() == 2);
    CHECK((*results)[0].partition == "auto");
    CHECK((*results)[0].holds);
    CHECK((*results)[1].partition == "wrong");
    CHECK(!(*results)[1].holds);
    CHECK((*results)[1].largest_absolute == 2.0);
    image.partitions = {{"broken", "", {"part0", "part7"}}};
    const auto broken = check_declared_splits(image);
    REQUIRE(!broken.ok());
    CHECK(broken.error().message.find("partition 'broken'") != std::string::npos);
    CHECK(broken.error().message.find("part7") != std::string::npos);
    image.partitions = {{"empty", "", {}}};
    CHECK(!check_declared_splits(image).ok());
}

TEST_CASE("a heat map is brighter where the residual is larger", "[display][verify]") {
    const Folder folder;
    raylex::display::SplitResult result;
    result.bound = std::ldexp(1.0, -23);
    // None, then octaves from bound / 2^10 to 1, then not finite.
    result.residual = {0};
    for (int power = -33; power <= 0; ++power) result.residual.push_back(std::ldexp(1.0f, power));
    result.residual.push_back(std::numeric_limits<float>::infinity());
    const int width = static_cast<int>(result.residual.size());
    REQUIRE(raylex::display::write_residual_png(folder.path("map.png"), result, width, 1).ok());
    CHECK(!raylex::display::write_residual_png(folder.path("map.png"), result, width, 2).ok());

    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    REQUIRE(png_image_begin_read_from_file(&image, folder.path("map.png").c_str()) != 0);
    image.format = PNG_FORMAT_RGB;
    REQUIRE(image.width == result.residual.size());
    std::vector<unsigned char> rgb(PNG_IMAGE_SIZE(image));
    REQUIRE(png_image_finish_read(&image, nullptr, rgb.data(), 0, nullptr) != 0);
    const auto luma = [&rgb](std::size_t i) {
        return 0.2126 * rgb[3 * i] + 0.7152 * rgb[3 * i + 1] + 0.0722 * rgb[3 * i + 2];
    };
    CHECK(luma(0) == 0);
    for (std::size_t i = 2; i + 1 < result.residual.size(); ++i) {
        CAPTURE(i);
        CHECK(luma(i) >= luma(i - 1));
    }
    CHECK(luma(static_cast<std::size_t>(width) - 2) > 200);
    // The bound (2^-23 is entry 11) and twice the bound differ clearly: blue below, red above.
    CHECK(rgb[3 * 11 + 2] > rgb[3 * 11]);
    CHECK(rgb[3 * 12] > 2 * rgb[3 * 12 + 2]);
    const std::size_t last = result.residual.size() - 1;
    CHECK(std::vector<unsigned char>(rgb.begin() + static_cast<std::ptrdiff_t>(3 * last), rgb.end()) ==
          std::vector<unsigned char>{0, 255, 255});
}
