#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "display/output/primaries.h"
#include "display/output/split_check.h"
#include "files.h"

using namespace raylex::test;
using raylex::display::compare;
using raylex::display::CompareMetric;
using raylex::display::StoredType;

namespace {

double value(const raylex::display::ExrImage& a, const raylex::display::ExrImage& b, CompareMetric metric,
             char component, const std::string& layer = "") {
    const auto result = compare(a, b, metric, layer, component);
    if (!result) FAIL(result.error().message);
    return *result;
}

// Two pixels, values exact in float.
const auto image = image_of(2, 1, {color_layer("", {{1.5f, 2, 0}, {0.5f, 4, 1}})});
const auto reference = image_of(2, 1, {color_layer("", {{1, 2, 0.5f}, {0, 2, 1}})});

}  // namespace

TEST_CASE("metrics are the formulas they name, computed by hand", "[display][compare]") {
    // Differences R: 0.5, 0.5; G: 0, 2; B: -0.5, 0. References R: 1, 0; G: 2, 2; B: 0.5, 1.
    // Double arithmetic on exact values: 1e-12 leaves room for the order of the additions.
    CHECK(value(image, reference, CompareMetric::mse, 'R') == Approx(0.25).epsilon(1e-12));
    CHECK(value(image, reference, CompareMetric::mse, 'G') == Approx(2.0).epsilon(1e-12));
    CHECK(value(image, reference, CompareMetric::mse, 'A') == Approx((0.25 + 0.25 + 4 + 0.25) / 6).epsilon(1e-12));
    CHECK(value(image, reference, CompareMetric::mae, 'B') == Approx(0.25).epsilon(1e-12));
    CHECK(value(image, reference, CompareMetric::mae, 'A') == Approx((0.5 + 0.5 + 2 + 0.5) / 6).epsilon(1e-12));
    CHECK(value(image, reference, CompareMetric::mape, 'R') == Approx((0.5 / 1.01 + 0.5 / 0.01) / 2).epsilon(1e-12));
    CHECK(value(image, reference, CompareMetric::relmse, 'R') ==
          Approx((0.25 / 1.01 + 0.25 / 0.01) / 2).epsilon(1e-12));
    CHECK(value(image, reference, CompareMetric::relmse, 'A') ==
          Approx((0.25 / 1.01 + 0.25 / 0.01 + 0 + 4 / 4.01 + 0.25 / 0.26 + 0) / 6).epsilon(1e-12));
    CHECK(value(image, reference, CompareMetric::mean_ratio, 'G') == Approx(6.0 / 4.0).epsilon(1e-12));
    CHECK(value(image, reference, CompareMetric::mean_ratio, 'A') == Approx(9.0 / 6.5).epsilon(1e-12));
    const double luminance[4] = {0.2126 * 1.5 + 0.7152 * 2, 0.2126 * 0.5 + 0.7152 * 4 + 0.0722,
                                 0.2126 + 0.7152 * 2 + 0.0722 * 0.5, 0.7152 * 2 + 0.0722};
    CHECK(value(image, reference, CompareMetric::mean_ratio, 'Y') ==
          Approx((luminance[0] + luminance[1]) / (luminance[2] + luminance[3])).epsilon(1e-12));
    CHECK(value(image, reference, CompareMetric::mae, 'Y') ==
          Approx((std::abs(luminance[0] - luminance[2]) + std::abs(luminance[1] - luminance[3])) / 2).epsilon(1e-12));
    CHECK(value(reference, reference, CompareMetric::relmse, 'A') == 0);
    CHECK(value(reference, reference, CompareMetric::mean_ratio, 'A') == 1);
    CHECK(std::string(formula(CompareMetric::relmse)) == "mean((a-b)^2 / (b^2 + 0.01))");
    CHECK(std::string(formula(CompareMetric::mean_ratio)) == "mean(a) / mean(b)");
}

TEST_CASE("the second image is the reference: metrics are not symmetric", "[display][compare]") {
    CHECK(value(image, reference, CompareMetric::relmse, 'R') != value(reference, image, CompareMetric::relmse, 'R'));
    CHECK(value(image, reference, CompareMetric::mean_ratio, 'R') ==
          Approx(1 / value(reference, image, CompareMetric::mean_ratio, 'R')));
}

TEST_CASE("images in different primaries are compared in the reference's", "[display][compare][color]") {
    using namespace raylex::display;
    // Rec. 709 red is (.613097, .070194, .020616) in ACEScg (OpenColorIO's builtin transform, six digits).
    auto red = image_of(1, 1, {color_layer("", {{1, 0, 0}}), color_layer("Nn", {{1, 0, 0}})});
    auto same = image_of(1, 1, {color_layer("", {{0.613097f, 0.070194f, 0.020616f}}), color_layer("Nn", {{1, 0, 0}})});
    red.chromaticities = rec709_primaries();
    same.chromaticities = aces_ap1_primaries();
    CHECK(value(red, same, CompareMetric::mae, 'A') < 1e-6);  // the digits given
    CHECK(value(same, red, CompareMetric::mae, 'A') < 5e-6);  // the way back stretches them
    CHECK(value(red, same, CompareMetric::mean_ratio, 'R') == Approx(1).epsilon(2e-6));
    red.chromaticities.reset();  // a file that does not say is Rec. 709
    CHECK(value(red, same, CompareMetric::mae, 'A') < 1e-6);
    same.chromaticities.reset();
    CHECK(value(red, same, CompareMetric::mae, 'R') == Approx(1 - 0.613097));
    // Luminance is that of the reference's primaries.
    auto grey = image_of(1, 1, {color_layer("", {{0, 1, 0}})}), white = image_of(1, 1, {color_layer("", {{1, 1, 1}})});
    grey.chromaticities = white.chromaticities = aces_ap1_primaries();
    CHECK(value(grey, white, CompareMetric::mean_ratio, 'Y') ==
          Approx(0.6740817658).epsilon(1e-6));  // S-2014-004, AP1 to XYZ
}

TEST_CASE("positions and single planes are never converted", "[display][compare]") {
    using namespace raylex::display;
    const ImageLayer position{"P",
                              "P",
                              {{"X", StoredType::single_float, {1}},
                               {"Y", StoredType::single_float, {2}},
                               {"Z", StoredType::single_float, {3}}}};
    const ImageLayer depth{"z", "z", {{"Z", StoredType::single_float, {4}}}};
    auto a = image_of(1, 1, {position, depth}), b = a;
    a.chromaticities = rec709_primaries();
    b.chromaticities = aces_ap1_primaries();
    CHECK(value(a, b, CompareMetric::mae, 'A', "P") == 0);
    CHECK(value(a, b, CompareMetric::mae, 'Y', "z") == 0);
    b.layers[0].planes[1].values[0] = 5;
    CHECK(value(a, b, CompareMetric::mae, 'Y', "P") == 3);
    CHECK(value(a, b, CompareMetric::mae, 'G', "P") == 3);
    CHECK(value(a, b, CompareMetric::mae, 'R', "P") == 0);
    b.layers[1].planes[0].values[0] = 6;
    for (const char component : {'R', 'G', 'B', 'Y', 'A'}) CHECK(value(a, b, CompareMetric::mae, component, "z") == 2);
}

TEST_CASE("misses at infinite depth agree with one another and with nothing else", "[display][compare][law6]") {
    constexpr float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
    const auto depths = [](std::vector<float> values) {
        return image_of(2, 1, {{"z", "z", {{"Z", StoredType::single_float, std::move(values)}}}});
    };
    CHECK(value(depths({inf, 2}), depths({inf, 4}), CompareMetric::mae, 'R', "z") == 1);
    CHECK(value(depths({inf, 2}), depths({inf, 4}), CompareMetric::mean_ratio, 'R', "z") == 0.5);
    CHECK(std::isinf(value(depths({inf, 2}), depths({1, 4}), CompareMetric::mae, 'R', "z")));
    CHECK(std::isnan(value(depths({nan, 2}), depths({1, 4}), CompareMetric::mse, 'R', "z")));
}

TEST_CASE("images that cannot be compared get errors that say why", "[display][compare][law7]") {
    const auto wide = image_of(1, 2, {color_layer("", {{1, 1, 1}, {1, 1, 1}})});
    const auto sizes = compare(image, wide, CompareMetric::mse, "", 'A');
    REQUIRE(!sizes.ok());
    CHECK(sizes.error().message.find("2 x 1") != std::string::npos);
    CHECK(sizes.error().message.find("1 x 2") != std::string::npos);
    const auto layer = compare(image, reference, CompareMetric::mse, "difuse", 'A');
    REQUIRE(!layer.ok());
    CHECK(layer.error().message.find("difuse") != std::string::npos);
    CHECK(!compare(image, reference, CompareMetric::mse, "", 'Q').ok());
    CHECK(compare(image, reference, CompareMetric::mse, "beauty", 'A').ok());
}
