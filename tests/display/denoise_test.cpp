// Denoised layers: they sum, improve, keep what has no noise, and have the same bits for any number of threads.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <random>

#include "display/output/denoise/denoise.h"
#include "display/output/denoise/layer_sums.h"

using namespace raylex::display;

namespace {

constexpr int denoised_width = 90, denoised_height = 70;
constexpr std::size_t denoised_pixels = std::size_t{denoised_width} * denoised_height;

/// A layer with noise of a given deviation around `truth(x, y)`.
template <class Truth>
NoisyLayer noisy_layer(unsigned seed, float deviation, Truth truth) {
    std::mt19937 random(seed);
    std::normal_distribution<float> normal(0, 1);
    NoisyLayer layer;
    for (std::size_t c = 0; c < 3; ++c)
        for (int y = 0; y < denoised_height; ++y)
            for (int x = 0; x < denoised_width; ++x) {
                layer.values[c].push_back(truth(x, y) + deviation * normal(random));
                layer.variance[c].push_back(deviation * deviation);
            }
    return layer;
}

float step_at_40(int x, int /*y*/) {
    return x < 40 ? 1.0f : 3.0f;
}
float ramp(int x, int y) {
    return 2 + 0.02f * static_cast<float>(x) + 0.01f * static_cast<float>(y);
}

/// A beauty that is the sum of a noisy ramp, a step with less noise, and a step without noise.
NoisyImage noisy_image() {
    NoisyImage image;
    image.width = denoised_width;
    image.height = denoised_height;
    image.layers = {{},
                    noisy_layer(1, 0.5f, ramp),
                    noisy_layer(2, 0.1f, step_at_40),
                    noisy_layer(3, 0, [](int x, int y) { return x + y > 60 ? 1.0f : 0.0f; })};
    NoisyLayer& beauty = image.layers[0];
    for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t i = 0; i < denoised_pixels; ++i) {
            double value = 0, variance = 0;
            for (std::size_t l = 1; l < 4; ++l) {
                value += static_cast<double>(image.layers[l].values[c][i]);
                variance += static_cast<double>(image.layers[l].variance[c][i]);
            }
            beauty.values[c].push_back(static_cast<float>(value));
            beauty.variance[c].push_back(static_cast<float>(variance));
        }
    image.sums = {{0, {1, 2, 3}}};
    return image;
}

template <class Truth>
double squared_error(const NoisyLayer& layer, Truth truth) {
    double sum = 0;
    for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t i = 0; i < denoised_pixels; ++i) {
            const double error =
                static_cast<double>(layer.values[c][i]) -
                static_cast<double>(truth(static_cast<int>(i) % denoised_width, static_cast<int>(i) / denoised_width));
            sum += error * error;
        }
    return sum / (3 * denoised_pixels);
}

}  // namespace

TEST_CASE("denoised layers improve, and sum to Law 1's bound", "[law1]") {
    const NoisyImage before = noisy_image();
    NoisyImage image = before;
    const std::vector<LayerError> errors = denoise(image, 2);
    REQUIRE(errors.size() == 4);
    CHECK(squared_error(image.layers[1], ramp) < 0.1 * squared_error(before.layers[1], ramp));
    CHECK(squared_error(image.layers[2], step_at_40) < 0.25 * squared_error(before.layers[2], step_at_40));
    CHECK(image.layers[3].values == before.layers[3].values);  // it has no noise
    for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t i = 0; i < denoised_pixels; ++i) {
            const auto beauty = static_cast<double>(image.layers[0].values[c][i]);
            double sum = 0, scale = std::abs(beauty);
            for (std::size_t l = 1; l < 4; ++l) {
                sum += static_cast<double>(image.layers[l].values[c][i]);
                scale += std::abs(static_cast<double>(image.layers[l].values[c][i]));
            }
            if (std::abs(sum - beauty) > 0x1p-23 * scale) FAIL("pixel " << i << ": " << sum << " against " << beauty);
        }
}

TEST_CASE("the estimated error of a denoised layer is near the true one") {
    NoisyImage image = noisy_image();
    const std::vector<LayerError> errors = denoise(image, 2);
    CHECK(errors[1].before == Approx(0.25).epsilon(0.1));
    const double truth = squared_error(image.layers[1], ramp);
    CHECK(errors[1].after > 0.4 * truth);
    CHECK(errors[1].after < 2.5 * truth);
    CHECK(errors[3].after == 0);
    CHECK(errors[1].light_after == Approx(errors[1].light).epsilon(1e-3));
    REQUIRE(image.layers[1].variance[0].size() == denoised_pixels);
    double mean = 0;
    for (const float each : image.layers[1].variance[0]) mean += static_cast<double>(each) / denoised_pixels;
    CHECK(1.6 * mean == Approx(errors[1].after));  // the mean includes what estimates of single pixels miss
    CHECK((errors[1].least < truth && truth < errors[1].most));
}

TEST_CASE("denoising has the same bits for any number of threads", "[law3]") {
    NoisyImage one = noisy_image();
    denoise(one, 1);
    for (const int threads : {2, 3}) {
        NoisyImage other = noisy_image();
        denoise(other, threads);
        for (std::size_t l = 0; l < one.layers.size(); ++l) {
            CHECK(other.layers[l].values == one.layers[l].values);
            CHECK(other.layers[l].variance[0] == one.layers[l].variance[0]);
        }
    }
}

TEST_CASE("a feature keeps an edge that the noise of a layer hides") {
    const auto edge = [](int x, int y) { return (x / 8 + y / 8) % 2 == 0 ? 1.0f : 1.4f; };
    NoisyImage plain;
    plain.width = denoised_width;
    plain.height = denoised_height;
    plain.layers = {noisy_layer(5, 0.5f, edge)};
    NoisyImage guided = plain;
    FilterFeature& feature = guided.features.emplace_back();
    for (int y = 0; y < denoised_height; ++y)
        for (int x = 0; x < denoised_width; ++x) feature.values.push_back(edge(x, y) - 1);
    denoise(plain, 2);
    denoise(guided, 2);
    CHECK(squared_error(guided.layers[0], edge) < 0.5 * squared_error(plain.layers[0], edge));
}

TEST_CASE("an edge whose stated variance comes from its own change keeps its pixels") {
    constexpr int samples = 64;
    const auto coverage = [](int x, int y) {
        return std::clamp(0.5f + static_cast<float>(x) - 30 - 0.37f * static_cast<float>(y), 0.0f, 1.0f);
    };
    NoisyImage image;
    image.width = denoised_width;
    image.height = denoised_height;
    image.layers = {noisy_layer(7, 0, coverage)};
    double stated = 0;
    for (std::size_t i = 0; i < denoised_pixels; ++i) {
        const float value = image.layers[0].values[0][i], variance = value * (1 - value) / samples;
        for (std::vector<float>& plane : image.layers[0].variance) plane[i] = variance;
        stated += static_cast<double>(variance) / denoised_pixels;
    }
    denoise(image, 2);
    CHECK(squared_error(image.layers[0], coverage) < 0.02 * stated);
}

TEST_CASE("layers without a partition take the step of the beauty, so that sums nobody declared hold") {
    NoisyImage image = noisy_image();
    image.sums.clear();
    denoise(image, 2);
    double largest = 0;
    for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t i = 0; i < denoised_pixels; ++i) {
            double sum = 0;
            for (std::size_t l = 1; l < 4; ++l) sum += static_cast<double>(image.layers[l].values[c][i]);
            largest = std::max(largest, std::abs(sum - static_cast<double>(image.layers[0].values[c][i])));
        }
    CHECK(largest < 1e-5);
}

TEST_CASE("the least change makes layers of several partitions sum, and keeps signs") {
    // whole = a + b, whole = c + d, a = e + f
    const std::vector<LayerIdentity> identities{{0, {1, 2}}, {0, {3, 4}}, {1, {5, 6}}};
    LayerSums sums(identities, 7);
    const std::vector<double> noisy{3, 1, 2, 3, 0, 0.5, 0.5}, risk{0.1, 0.2, 0.1, 0.4, 0, 0.1, 0.3};
    std::vector<double> values{2.5, 1.2, 1.9, 2.8, 0, 0.4, 0.3};
    sums.make_sum(noisy, risk, values);
    CHECK(values[1] + values[2] == Approx(values[0]).epsilon(1e-13));
    CHECK(values[3] + values[4] == Approx(values[0]).epsilon(1e-13));
    CHECK(values[5] + values[6] == Approx(values[1]).epsilon(1e-13));
    CHECK(values[4] == 0);  // it has no risk
    std::vector<double> reduced(7);
    sums.reduce_risk(risk, reduced);
    for (std::size_t i = 0; i < risk.size(); ++i) CHECK(reduced[i] <= risk[i]);
    CHECK(reduced[0] < 0.08);

    // the layer 2 would become -0.5
    const std::vector<LayerIdentity> one{{0, {1, 2}}};
    LayerSums pair(one, 3);
    std::vector<double> negative{1, 2, 0};
    pair.make_sum(std::vector<double>{1, 1, 0}, std::vector<double>{0, 0.5, 0.5}, negative);
    CHECK(negative == std::vector<double>{1, 1, 0});
}
