#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "display/output/color/primaries.h"
#include "display/output/comparison/comparison.h"
#include "display/output/splits/split_check.h"
#include "files.h"

using namespace raylex::test;
using raylex::display::compare;
using raylex::display::ErrorMetric;
using raylex::display::StoredType;

namespace {

double value(const raylex::display::ExrImage& a, const raylex::display::ExrImage& b, ErrorMetric metric, char component,
             const std::string& layer = "") {
    const auto result = compare(a, b, metric, layer, component);
    if (!result) FAIL(result.error().message);
    return *result;
}

// Two pixels with values that are exact in float.
const auto image = image_of(2, 1, {color_layer("", {{1.5f, 2, 0}, {0.5f, 4, 1}})});
const auto reference = image_of(2, 1, {color_layer("", {{1, 2, 0.5f}, {0, 2, 1}})});

}  // namespace

TEST_CASE("metrics agree with their formulas, computed by hand", "[display][compare]") {
    // Differences R: 0.5, 0.5; G: 0, 2; B: -0.5, 0. References R: 1, 0; G: 2, 2; B: 0.5, 1.
    // Double arithmetic on exact values: 1e-12 allows for the order of the additions.
    CHECK(value(image, reference, ErrorMetric::mse, 'R') == Approx(0.25).epsilon(1e-12));
    CHECK(value(image, reference, ErrorMetric::mse, 'G') == Approx(2.0).epsilon(1e-12));
    CHECK(value(image, reference, ErrorMetric::mse, 'A') == Approx((0.25 + 0.25 + 4 + 0.25) / 6).epsilon(1e-12));
    CHECK(value(image, reference, ErrorMetric::mae, 'B') == Approx(0.25).epsilon(1e-12));
    CHECK(value(image, reference, ErrorMetric::mae, 'A') == Approx((0.5 + 0.5 + 2 + 0.5) / 6).epsilon(1e-12));
    CHECK(value(image, reference, ErrorMetric::mape, 'R') == Approx((0.5 / 1.01 + 0.5 / 0.01) / 2).epsilon(1e-12));
    CHECK(value(image, reference, ErrorMetric::relmse, 'R') == Approx((0.25 / 1.01 + 0.25 / 0.01) / 2).epsilon(1e-12));
    CHECK(value(image, reference, ErrorMetric::relmse, 'A') ==
          Approx((0.25 / 1.01 + 0.25 / 0.01 + 0 + 4 / 4.01 + 0.25 / 0.26 + 0) / 6).epsilon(1e-12));
    CHECK(value(image, reference, ErrorMetric::mean_ratio, 'G') == Approx(6.0 / 4.0).epsilon(1e-12));
    CHECK(value(image, reference, ErrorMetric::mean_ratio, 'A') == Approx(9.0 / 6.5).epsilon(1e-12));
    const double luminance[4] = {0.2126 * 1.5 + 0.7152 * 2, 0.2126 * 0.5 + 0.7152 * 4 + 0.0722,
                                 0.2126 + 0.7152 * 2 + 0.0722 * 0.5, 0.7152 * 2 + 0.0722};
    CHECK(value(image, reference, ErrorMetric::mean_ratio, 'Y') ==
          Approx((luminance[0] + luminance[1]) / (luminance[2] + luminance[3])).epsilon(1e-12));
    CHECK(value(image, reference, ErrorMetric::mae, 'Y') ==
          Approx((std::abs(luminance[0] - luminance[2]) + std::abs(luminance[1] - luminance[3])) / 2).epsilon(1e-12));
    CHECK(value(reference, reference, ErrorMetric::relmse, 'A') == 0);
    CHECK(value(reference, reference, ErrorMetric::mean_ratio, 'A') == 1);
    CHECK(std::string(formula(ErrorMetric::relmse)) == "mean((a-b)^2 / (b^2 + 0.01))");
    CHECK(std::string(formula(ErrorMetric::mean_ratio)) == "mean(a) / mean(b)");
}

TEST_CASE("the name of a metric can have underscores", "[display][compare]") {
    for (const raylex::display::AnyMetric& each : raylex::display::all_metrics()) {
        std::string name = each.name;
        std::replace(name.begin(), name.end(), '-', '_');
        CAPTURE(name);
        const auto found = raylex::display::require_metric(name, {});
        REQUIRE(found);
        CHECK(found->name == each.name);
    }
    CHECK_FALSE(raylex::display::require_metric("mean__ratio", {}));
}

TEST_CASE("the second image is the reference: metrics are not symmetric", "[display][compare]") {
    CHECK(value(image, reference, ErrorMetric::relmse, 'R') != value(reference, image, ErrorMetric::relmse, 'R'));
    CHECK(value(image, reference, ErrorMetric::mean_ratio, 'R') ==
          Approx(1 / value(reference, image, ErrorMetric::mean_ratio, 'R')));
}

TEST_CASE("images in different primaries are compared in the reference's primaries", "[display][compare][color]") {
    using namespace raylex::display;
    // Rec. 709 red is (.613097, .070194, .020616) in ACEScg (OpenColorIO's builtin transform, six digits).
    auto red = image_of(1, 1, {color_layer("", {{1, 0, 0}}), color_layer("Nn", {{1, 0, 0}})});
    auto same = image_of(1, 1, {color_layer("", {{0.613097f, 0.070194f, 0.020616f}}), color_layer("Nn", {{1, 0, 0}})});
    red.chromaticities = rec709_primaries();
    same.chromaticities = aces_ap1_primaries();
    CHECK(value(red, same, ErrorMetric::mae, 'A') < 1e-6);  // the digits of the reference
    CHECK(value(same, red, ErrorMetric::mae, 'A') < 5e-6);  // the inverse magnifies the error
    CHECK(value(red, same, ErrorMetric::mean_ratio, 'R') == Approx(1).epsilon(2e-6));
    red.chromaticities.reset();  // a file without chromaticities is Rec. 709
    CHECK(value(red, same, ErrorMetric::mae, 'A') < 1e-6);
    same.chromaticities.reset();
    CHECK(value(red, same, ErrorMetric::mae, 'R') == Approx(1 - 0.613097));
    // Luminance uses the reference's primaries.
    auto grey = image_of(1, 1, {color_layer("", {{0, 1, 0}})}), white = image_of(1, 1, {color_layer("", {{1, 1, 1}})});
    grey.chromaticities = white.chromaticities = aces_ap1_primaries();
    CHECK(value(grey, white, ErrorMetric::mean_ratio, 'Y') ==
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
    CHECK(value(a, b, ErrorMetric::mae, 'A', "P") == 0);
    CHECK(value(a, b, ErrorMetric::mae, 'Y', "z") == 0);
    b.layers[0].planes[1].values[0] = 5;
    CHECK(value(a, b, ErrorMetric::mae, 'Y', "P") == 3);
    CHECK(value(a, b, ErrorMetric::mae, 'G', "P") == 3);
    CHECK(value(a, b, ErrorMetric::mae, 'R', "P") == 0);
    b.layers[1].planes[0].values[0] = 6;
    for (const char component : {'R', 'G', 'B', 'Y', 'A'}) CHECK(value(a, b, ErrorMetric::mae, component, "z") == 2);
}

TEST_CASE("infinite depths agree only with infinite depths", "[display][compare][law6]") {
    constexpr float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
    const auto depths = [](std::vector<float> values) {
        return image_of(2, 1, {{"z", "z", {{"Z", StoredType::single_float, std::move(values)}}}});
    };
    CHECK(value(depths({inf, 2}), depths({inf, 4}), ErrorMetric::mae, 'R', "z") == 1);
    CHECK(value(depths({inf, 2}), depths({inf, 4}), ErrorMetric::mean_ratio, 'R', "z") == 0.5);
    CHECK(std::isinf(value(depths({inf, 2}), depths({1, 4}), ErrorMetric::mae, 'R', "z")));
    const auto message = [&](std::vector<float> a, std::vector<float> b, ErrorMetric metric) {
        const auto result = compare(depths(std::move(a)), depths(std::move(b)), metric, "z", 'R');
        return result ? "a value: " + std::to_string(*result) : result.error().message;
    };
    CHECK(message({nan, 2}, {1, 4}, ErrorMetric::mse) ==
          "mse of layer 'z' has no value: 1 of its 2 values are inf or nan");
    CHECK(message({1, 2}, {nan, nan}, ErrorMetric::trimmed_relmse_mean) ==
          "trimmed-relmse-mean of layer 'z' has no value: 2 of its 2 values are inf or nan");
    CHECK(message({1, 2}, {inf, 4}, ErrorMetric::mean_ratio) ==
          "mean-ratio of layer 'z' has no value: 1 of its 2 values are inf or nan");  // not 0
    // Both images have no hit: no value is bad, but the mean to divide by is 0.
    CHECK(message({inf, inf}, {inf, inf}, ErrorMetric::mean_ratio) ==
          "there is no ratio mean(a) / mean(b): the mean of 'z' is 0 in this reference");
    CHECK(message({inf, nan}, {inf, 4}, ErrorMetric::mean_ratio) ==
          "mean-ratio of layer 'z' has no value: 1 of its 2 values are inf or nan");
}

TEST_CASE("black layers have every metric except the ratio, which is an error", "[display][compare][law7]") {
    auto black = image_of(2, 1, {color_layer("", {{0, 0, 0}, {0, 0, 0}})});
    black.path = "black.exr";
    for (const raylex::display::ErrorMetricInfo& each : raylex::display::error_metrics()) {
        CAPTURE(each.name);
        const auto same = compare(black, black, each.metric, "", 'A');
        const auto lit = compare(image, black, each.metric, "", 'A');
        const bool ratio = each.metric == ErrorMetric::mean_ratio;
        REQUIRE(same.ok() != ratio);
        REQUIRE(lit.ok() != ratio);
        if (ratio) {
            for (const auto* none : {&same, &lit}) {
                CHECK(none->error().file == "black.exr");
                CHECK(none->error().message.find("there is no ratio mean(a) / mean(b)") == 0);
            }
        } else {
            CHECK(*same == 0);
            CHECK(*lit > 0);  // inf where the floor depends on the black reference's mean
        }
    }
    CHECK(value(black, image, ErrorMetric::mean_ratio, 'A') == 0);
}

TEST_CASE("images that cannot be compared get errors that say why", "[display][compare][law7]") {
    const auto wide = image_of(1, 2, {color_layer("", {{1, 1, 1}, {1, 1, 1}})});
    const auto sizes = compare(image, wide, ErrorMetric::mse, "", 'A');
    REQUIRE(!sizes.ok());
    CHECK(sizes.error().message.find("2 x 1") != std::string::npos);
    CHECK(sizes.error().message.find("1 x 2") != std::string::npos);
    const auto layer = compare(image, reference, ErrorMetric::mse, "difuse", 'A');
    REQUIRE(!layer.ok());
    CHECK(layer.error().message.find("difuse") != std::string::npos);
    CHECK(!compare(image, reference, ErrorMetric::mse, "", 'Q').ok());
    CHECK(compare(image, reference, ErrorMetric::mse, "beauty", 'A').ok());
}

TEST_CASE("scale-invariant metrics do not change with the exposure", "[display][compare]") {
    using namespace raylex::display;
    // m = 2; the floor is (0.1 * 2)^2 = 0.04. Squared relative errors: 0.25 / 4.04, 0, 1 / 0.04 and 0.
    const std::vector<double> a{1.5, 3, 1, 3}, b{2, 3, 0, 3};
    const ErrorMeasures measures = measure_errors(a, b);
    CHECK(measures[ErrorMetric::relmse_mean] == Approx((0.25 / 4.04 + 1 / 0.04) / 4).epsilon(1e-14));
    CHECK(measures[ErrorMetric::rmse] == Approx(std::sqrt(1.25 / 4)).epsilon(1e-14));
    CHECK(measures[ErrorMetric::smape] == Approx((1 / 3.5 + 2) / 4).epsilon(1e-14));
    CHECK(measures.trimmed_share == 0);  // 0.1 % of four terms is none
    std::vector<double> a2, b2;
    for (std::size_t i = 0; i < a.size(); ++i) {
        a2.push_back(a[i] * 1024);  // a power of two changes only the exponent
        b2.push_back(b[i] * 1024);
    }
    CHECK(measure_errors(a2, b2)[ErrorMetric::relmse_mean] == measures[ErrorMetric::relmse_mean]);
}

TEST_CASE("trimming removes the largest terms and reports their share", "[display][compare]") {
    using namespace raylex::display;
    // 2,000 references of 1 make the floor 0.01 and every term d^2 / 1.01; two terms are trimmed.
    std::vector<double> a(2000, 1.0), b(2000, 1.0);
    a[10] = 101, a[20] = 51, a[30] = 3;
    const ErrorMeasures measures = measure_errors(a, b);
    CHECK(measures[ErrorMetric::trimmed_relmse_mean] == Approx(4 / 1.01 / 1998).epsilon(1e-10));
    CHECK(measures.trimmed_share == Approx(12500.0 / 12504).epsilon(1e-12));
    a[30] = std::numeric_limits<double>::infinity();  // is never trimmed
    CHECK(std::isinf(measure_errors(a, b)[ErrorMetric::trimmed_relmse_mean]));
}

TEST_CASE("the excess from a reference's variance has the weights of the metric", "[display][compare]") {
    using namespace raylex::display;
    const std::vector<double> reference{2, 0}, variance{0.5, 0.25};  // m = 1
    CHECK(reference_excess(ErrorMetric::mse, reference, variance) == Approx(0.375).epsilon(1e-14));
    CHECK(reference_excess(ErrorMetric::relmse, reference, variance) == Approx((0.5 / 4.01 + 25) / 2).epsilon(1e-14));
    CHECK(reference_excess(ErrorMetric::relmse_mean, reference, variance) ==
          Approx((0.5 / 4.01 + 25) / 2).epsilon(1e-14));
    CHECK(std::isnan(reference_excess(ErrorMetric::mae, reference, variance)));
}
