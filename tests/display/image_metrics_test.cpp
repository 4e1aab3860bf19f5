// SSIM, FLIP and HDR-FLIP against values derived by hand and against direct sums; error images.
#include <catch2/catch.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "display/output/color/primaries.h"
#include "display/output/comparison/comparison.h"
#include "display/output/metrics/image_metrics.h"
#include "files.h"

using namespace raylex::display;
using namespace raylex::test;

namespace {

using Color = std::array<double, 3>;

LinearImage flat(int width, int height, const Color& color) {
    LinearImage image{width, height, {}};
    for (int i = 0; i < width * height; ++i) image.rgb.insert(image.rgb.end(), color.begin(), color.end());
    return image;
}

LinearImage noise(int width, int height, unsigned seed, double most = 1) {
    LinearImage image = flat(width, height, {});
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> value(0, most);
    for (double& each : image.rgb) each = value(random);
    return image;
}

double mean_of(const std::vector<double>& values) {
    double sum = 0;
    for (const double each : values) sum += each;
    return sum / static_cast<double>(values.size());
}

double encoded(double y) {
    return y <= 0.0031308 ? 12.92 * y : 1.055 * std::pow(y, 1 / 2.4) - 0.055;
}

// FLIP directly from the publication: sums over all neighbours of one pixel, without separable filters.
class PlainFlip {
  public:
    explicit PlainFlip(const LinearImage& image) : image_(image) {}

    // The colour as the eye resolves it, and the strengths of edge and point, at (x, y).
    struct Seen {
        Color lab;
        double edge, point;
    };
    [[nodiscard]] Seen at(int x, int y) const {
        constexpr double pi = std::numbers::pi, ppd = flip_pixels_per_degree;
        constexpr double table[3][4] = {{1, 0.0047, 0, 1e-5}, {1, 0.0053, 0, 1e-5}, {34.1, 0.04, 13.5, 0.025}};
        const int r = static_cast<int>(std::ceil(3 * std::sqrt(0.04 / (2 * pi * pi)) * ppd));
        Color sums{}, weights{};
        for (int v = -r; v <= r; ++v)
            for (int u = -r; u <= r; ++u) {
                const double d = (u * u + v * v) / (ppd * ppd);
                const Color value = ycxcz(pixel(x + u, y + v));
                for (std::size_t c = 0; c < 3; ++c) {
                    const double* t = table[c];
                    const double g = t[0] * std::sqrt(pi / t[1]) * std::exp(-pi * pi * d / t[1]) +
                                     t[2] * std::sqrt(pi / t[3]) * std::exp(-pi * pi * d / t[3]);
                    sums[c] += g * value[c];
                    weights[c] += g;
                }
            }
        Color rgb = back({sums[0] / weights[0], sums[1] / weights[1], sums[2] / weights[2]});
        for (double& each : rgb) each = std::clamp(each, 0.0, 1.0);
        return {lab(rgb), feature(x, y, false), feature(x, y, true)};
    }

    static double difference(const Seen& a, const Seen& b) {
        const double green_blue = std::pow(hyab(lab({0, 1, 0}), lab({0, 0, 1})), 0.7);
        const double c = std::pow(hyab(a.lab, b.lab), 0.7), knee = 0.4 * green_blue;
        const double color = c < knee ? 0.95 / knee * c : 0.95 + (c - knee) / (green_blue - knee) * 0.05;
        const double f = std::max(std::abs(a.edge - b.edge), std::abs(a.point - b.point));
        return std::pow(color, 1 - std::sqrt(f / std::sqrt(2.0)));
    }

  private:
    [[nodiscard]] Color pixel(int x, int y) const {
        x = std::clamp(x, 0, image_.width - 1);
        y = std::clamp(y, 0, image_.height - 1);
        Color rgb{};
        for (std::size_t c = 0; c < 3; ++c)
            rgb[c] = std::clamp(image_.rgb[3 * static_cast<std::size_t>(y * image_.width + x) + c], 0.0, 1.0);
        return rgb;
    }
    static Color relative_xyz(const Color& rgb) {
        const Matrix3 m = rgb_to_xyz(rec709_primaries());
        const Color xyz = transform_colour(m, rgb), white = transform_colour(m, {1, 1, 1});
        return {xyz[0] / white[0], xyz[1] / white[1], xyz[2] / white[2]};
    }
    static Color ycxcz(const Color& rgb) {
        const Color t = relative_xyz(rgb);
        return {116 * t[1] - 16, 500 * (t[0] - t[1]), 200 * (t[1] - t[2])};
    }
    static Color back(const Color& value) {
        const Matrix3 m = rgb_to_xyz(rec709_primaries());
        const Color white = transform_colour(m, {1, 1, 1});
        const double y = (value[0] + 16) / 116;
        return transform_colour(inverse(m),
                                {(value[1] / 500 + y) * white[0], y * white[1], (y - value[2] / 200) * white[2]});
    }
    static Color lab(const Color& rgb) {
        Color t = relative_xyz(rgb);
        for (double& each : t) each = each > 216.0 / 24389 ? std::cbrt(each) : (24389.0 / 27 * each + 16) / 116;
        const double l = 116 * t[1] - 16;
        return {l, l / 100 * 500 * (t[0] - t[1]), l / 100 * 200 * (t[1] - t[2])};
    }
    static double hyab(const Color& a, const Color& b) {
        return std::abs(a[0] - b[0]) + std::sqrt((a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
    }
    [[nodiscard]] double feature(int x, int y, bool point) const {
        const double s = 0.5 * 0.082 * flip_pixels_per_degree;
        const int r = static_cast<int>(std::ceil(3 * s));
        const auto weight = [&](int u, int v) {
            const double g = std::exp(-(u * u + v * v) / (2 * s * s));
            return point ? (u * u / (s * s) - 1) * g : -u * g;
        };
        double positive = 0, negative = 0;
        for (int v = -r; v <= r; ++v)
            for (int u = -r; u <= r; ++u) (weight(u, v) > 0 ? positive : negative) += weight(u, v);
        double across = 0, down = 0;
        for (int v = -r; v <= r; ++v)
            for (int u = -r; u <= r; ++u) {
                const double w = weight(u, v) / (weight(u, v) > 0 ? positive : -negative);
                across += w * (ycxcz(pixel(x + u, y + v))[0] + 16) / 116;
                down += w * (ycxcz(pixel(x + v, y + u))[0] + 16) / 116;
            }
        return std::sqrt(across * across + down * down);
    }
    const LinearImage& image_;
};

}  // namespace

TEST_CASE("SSIM of constant images is its luminance term, and 1 for equal images", "[display][compare]") {
    const double a = encoded(0.2), b = encoded(0.5), c1 = 1e-4;
    const ImageErrors grey =
        measure_image(ImageMetric::ssim, flat(16, 12, {0.2, 0.2, 0.2}), flat(16, 12, {0.5, 0.5, 0.5}));
    CHECK(grey.value == Approx((2 * a * b + c1) / (a * a + b * b + c1)).epsilon(1e-9));
    for (const double each : grey.map) CHECK(each == Approx(1 - grey.value).epsilon(1e-9));
    const LinearImage image = noise(20, 20, 1);
    CHECK(measure_image(ImageMetric::ssim, image, image).value == Approx(1).epsilon(1e-12));
    // Values above the monitor's maximum are clamped to it.
    CHECK(measure_image(ImageMetric::ssim, flat(12, 12, {7, 7, 7}), flat(12, 12, {1, 1, 1})).value == Approx(1));
}

TEST_CASE("SSIM of one window equals the formula", "[display][compare]") {
    // 11 x 11 pixels: only the middle one's window is inside the image.
    const LinearImage a = noise(11, 11, 2), b = noise(11, 11, 3);
    double weights = 0, ma = 0, mb = 0, aa = 0, bb = 0, ab = 0;
    for (int y = 0; y < 11; ++y)
        for (int x = 0; x < 11; ++x) {
            const double w = std::exp(-((x - 5) * (x - 5) + (y - 5) * (y - 5)) / (2 * 1.5 * 1.5));
            const auto i = 3 * static_cast<std::size_t>(11 * y + x);
            const auto luma = [&](const LinearImage& of) {
                return encoded(0.2126 * of.rgb[i] + 0.7152 * of.rgb[i + 1] + 0.0722 * of.rgb[i + 2]);
            };
            const double p = luma(a), q = luma(b);
            weights += w;
            ma += w * p;
            mb += w * q;
            aa += w * p * p;
            bb += w * q * q;
            ab += w * p * q;
        }
    ma /= weights;
    mb /= weights;
    const double va = aa / weights - ma * ma, vb = bb / weights - mb * mb, vab = ab / weights - ma * mb;
    const double c1 = 1e-4, c2 = 9e-4;
    const double expected = (2 * ma * mb + c1) * (2 * vab + c2) / ((ma * ma + mb * mb + c1) * (va + vb + c2));
    const ImageErrors ssim = measure_image(ImageMetric::ssim, a, b);
    CHECK(ssim.value == Approx(expected).epsilon(1e-9));
    CHECK(ssim.map[60] == Approx(1 - expected).epsilon(1e-9));
    // A smaller image uses the parts of windows that are inside.
    const ImageErrors small = measure_image(ImageMetric::ssim, noise(3, 2, 4), noise(3, 2, 5));
    CHECK(small.value == Approx(1 - mean_of(small.map)));
    CHECK(small.value < 0.9);
}

TEST_CASE("FLIP of flat colours is only the colour part, computed by hand", "[display][compare]") {
    const auto flip = [](const Color& a, const Color& b) {
        return measure_image(ImageMetric::flip, flat(9, 7, a), flat(9, 7, b)).value;
    };
    CHECK(flip({0.3, 0.2, 0.1}, {0.3, 0.2, 0.1}) == 0);
    CHECK(flip({0, 1, 0}, {0, 0, 1}) == Approx(1).epsilon(1e-9));
    // Black and white: L* 0 and 100, no chroma: 100^0.7 = 25.119. Green and blue, their chroma scaled by L*: distance
    // 203.30, ^0.7 = 41.276. Above the knee 0.4 x 41.276: 0.95 + 0.05 (25.119 - 16.510) / (41.276 - 16.510) = 0.9674.
    CHECK(flip({0, 0, 0}, {1, 1, 1}) == Approx(0.9674).epsilon(1e-4));
    // Below the knee: L* 50 has Y = (66 / 116)^3; 50^0.7 = 15.462 of 16.510 is 0.95 x 0.9365.
    const double y = std::pow(66.0 / 116, 3);
    CHECK(flip({0, 0, 0}, {y, y, y}) == Approx(0.95 * std::pow(50, 0.7) / 16.5104).epsilon(1e-4));
    CHECK(flip({1, 1, 1}, {3, 2, 1}) == 0);  // clamped
}

TEST_CASE("FLIP is symmetric, between 0 and 1, and equals the publication's sums pixel by pixel",
          "[display][compare]") {
    LinearImage a = noise(13, 11, 6), b = noise(13, 11, 7);
    for (std::size_t i = 0; i < 90; ++i) a.rgb[i] = b.rgb[i] = 0.5;  // smooth above, so that features differ
    const ImageErrors flip = measure_image(ImageMetric::flip, a, b), back = measure_image(ImageMetric::flip, b, a);
    REQUIRE(flip.map.size() == 13 * 11);
    CHECK(flip.value == Approx(mean_of(flip.map)).epsilon(1e-12));
    for (std::size_t i = 0; i < flip.map.size(); ++i) {
        CHECK(flip.map[i] == Approx(back.map[i]).epsilon(1e-12));
        CHECK((flip.map[i] >= 0 && flip.map[i] <= 1));
    }
    const PlainFlip plain_a(a), plain_b(b);
    for (const auto& [x, y] : {std::pair{0, 0}, {6, 5}, {12, 10}, {3, 9}}) {
        CAPTURE(x, y);
        CHECK(flip.map[static_cast<std::size_t>(13 * y + x)] ==
              Approx(PlainFlip::difference(plain_a.at(x, y), plain_b.at(x, y))).epsilon(1e-9));
    }
}

TEST_CASE("HDR-FLIP does not depend on the exposure of the pair, and detects differences beyond the monitor's range",
          "[display][compare]") {
    LinearImage a = noise(12, 12, 8, 4), b = noise(12, 12, 9, 4);
    b.rgb[0] = b.rgb[1] = b.rgb[2] = 300;
    const double once = measure_image(ImageMetric::hdr_flip, a, b).value;
    CHECK(once > 0.05);
    for (double& each : a.rgb) each *= 1024;
    for (double& each : b.rgb) each *= 1024;
    CHECK(measure_image(ImageMetric::hdr_flip, a, b).value == Approx(once).epsilon(1e-9));
    CHECK(measure_image(ImageMetric::hdr_flip, a, a).value == 0);
    CHECK(measure_image(ImageMetric::hdr_flip, flat(4, 4, {}), flat(4, 4, {})).value == 0);
    // 2 and 8 are both white on a monitor; under some exposure they differ.
    const LinearImage two = flat(8, 8, {2, 2, 2});
    LinearImage eight = flat(8, 8, {8, 8, 8});
    CHECK(measure_image(ImageMetric::flip, two, eight).value == 0);
    CHECK(measure_image(ImageMetric::hdr_flip, two, eight).value > 0.1);
    // A reference of one colour has a single exposure, which shows it as 0.85; Narkowicz's curve then shows the image.
    const double shown = 0.85;
    const auto curve = [](double x) { return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14); };
    double low = 0, high = 10;  // curve(low) <= 0.85 <= curve(high), by bisection
    for (int i = 0; i < 100; ++i) (curve((low + high) / 2) < shown ? low : high) = (low + high) / 2;
    const double other = curve(low / 4);
    // The features of flat images differ by rounding, 1e-17, and the metric contains its square root.
    CHECK(measure_image(ImageMetric::hdr_flip, two, eight).value ==
          Approx(measure_image(ImageMetric::flip, flat(8, 8, {other, other, other}), flat(8, 8, {shown, shown, shown}))
                     .value)
              .epsilon(1e-7));
}

TEST_CASE("the mean of an error image is the metric", "[display][compare]") {
    std::vector<std::array<float, 3>> p, q;
    std::mt19937 random(10);
    std::uniform_real_distribution<float> value(0, 2);
    for (int i = 0; i < 12 * 12; ++i) {
        p.push_back({value(random), value(random), value(random)});
        q.push_back({value(random), value(random), value(random)});
    }
    const ExrImage a = image_of(12, 12, {color_layer("", p)}), b = image_of(12, 12, {color_layer("", q)});
    const auto pair = LayerPair::make(a, b, "");
    REQUIRE(pair);
    CHECK(all_metrics().size() == error_metric_count + image_metric_count);
    for (const AnyMetric& metric : all_metrics()) {
        CAPTURE(metric.name);
        REQUIRE(find_metric(metric.name));
        CHECK(metric.of_values.has_value() != metric.of_image.has_value());
        const auto whole = pair->value(metric, 'A');
        REQUIRE(whole);
        const auto errors = pair->errors(metric, 'A');
        if (metric.name == "mean-ratio") {
            REQUIRE(!errors);
            CHECK(errors.error().message.find("not defined for single pixels") != std::string::npos);
            continue;
        }
        REQUIRE(errors);
        CHECK(errors->value == *whole);
        REQUIRE(errors->map.size() == 144);
        if (metric.of_values == ErrorMetric::rmse) {
            double squares = 0;
            for (const double each : errors->map) squares += each * each;
            CHECK(std::sqrt(squares / 144) == Approx(*whole).epsilon(1e-12));
        } else if (metric.of_values == ErrorMetric::trimmed_relmse_mean) {  // a thousandth of 432 terms is none
            CHECK(mean_of(errors->map) == Approx(*whole).epsilon(1e-12));
        } else if (metric.of_image != ImageMetric::ssim) {
            CHECK(mean_of(errors->map) == Approx(*whole).epsilon(1e-12));
        }
    }
}

TEST_CASE("perceptual metrics refuse components, vectors and values that are not finite", "[display][compare][law7]") {
    const AnyMetric flip = *find_metric("flip");
    const auto message = [&](const ExrImage& a, const ExrImage& b, const std::string& layer, char component) {
        const auto pair = LayerPair::make(a, b, layer);
        REQUIRE(pair);
        const auto value = pair->value(flip, component);
        return value ? std::string("has a value") : value.error().message;
    };
    const ExrImage color = image_of(2, 1, {color_layer("", {{1, 1, 1}, {0, 0, 0}})});
    CHECK(message(color, color, "", 'A') == "has a value");
    CHECK(message(color, color, "", 'G').find("expected no --channel") != std::string::npos);
    const ExrImage infinite = image_of(2, 1, {color_layer("", {{1, INFINITY, 1}, {0, 0, 0}})});
    CHECK(message(infinite, infinite, "", 'A') == "flip of layer '' has no value: 1 of its 6 values are inf or nan");
    ImageLayer vectors{"P", "P", {{"X", {}, {1, 2}}, {"Y", {}, {1, 2}}, {"Z", {}, {1, 2}}}};
    const ExrImage positions = image_of(2, 1, {vectors});
    CHECK(message(positions, positions, "P", 'A').find("needs colours, and layer 'P' has none") != std::string::npos);
    const ExrImage grey = image_of(2, 1, {{"Y", "", {{"Y", {}, {0, 0}}}}}),
                   light = image_of(2, 1, {{"Y", "", {{"Y", {}, {1, 1}}}}});
    const auto pair = LayerPair::make(grey, light, "Y");
    REQUIRE(pair);
    CHECK(*pair->value(flip, 'A') == Approx(0.9674).epsilon(1e-4));
}
