// The weights of all bidirectional strategies of a path: they sum to 1, and each is what its densities say.
#include <catch2/catch.hpp>

#include <cmath>
#include <vector>

#include "tests/transport/materials_support.h"
#include "transport/paths/partial_mis_weights.h"

using raylex::test::Random;
using raylex::transport::PartialMisWeights;

namespace {

/// Vertices from the light (0) to the camera (last).
struct PathDensities {
    std::vector<double> from_light, from_camera;  // of each vertex, per area
    std::vector<bool> specular;
    double light_sample = 1;  // of vertex 0 as light sampling finds it
    bool can_be_hit = true;

    [[nodiscard]] std::size_t size() const { return specular.size(); }
    [[nodiscard]] bool connects(std::size_t s) const {
        if (s == 0) return can_be_hit;
        return s < size() && !specular[s - 1] && !specular[s];
    }
    /// Of the strategy with s vertices from the light, as a logarithm.
    [[nodiscard]] double density(std::size_t s) const {
        double sum = 0;
        for (std::size_t i = 0; i < size(); ++i)
            sum += std::log(i < s ? (s == 1 ? light_sample : from_light[i]) : from_camera[i]);
        return sum;
    }
};

PathDensities random_path(Random& random, std::size_t length, double spread, bool with_specular) {
    PathDensities path;
    const auto density = [&] { return std::exp(spread * (2 * static_cast<double>(random.one()) - 1)); };
    for (std::size_t i = 0; i < length; ++i) {
        path.from_light.push_back(density());
        path.from_camera.push_back(i + 1 == length ? 1 : density());
        const bool inner = i > 0 && i + 1 < length;
        path.specular.push_back(with_specular && inner && random.one() < 0.3f);
    }
    path.light_sample = density();
    path.can_be_hit = random.one() < 0.7f;
    return path;
}

/// Sums at the light subpath's vertex `last`, made vertex by vertex as a walk makes them.
PartialMisWeights from_light(const PathDensities& path, std::size_t last) {
    PartialMisWeights sums;
    sums.previous = path.from_light[0];
    sums.tail = path.can_be_hit ? 1 : 0;
    for (std::size_t k = 1; k <= last; ++k) {
        sums.arrive(path.from_light[k], 1);
        if (k == 1) sums.connects = std::pow(path.light_sample / path.from_light[0], 2);
        if (k < last) sums.leave(path.specular[k], path.from_camera[k - 1], 1);
    }
    return sums;
}

/// Sums at the camera subpath's vertex `last`, counted from the light.
PartialMisWeights from_camera(const PathDensities& path, std::size_t last) {
    PartialMisWeights sums;
    sums.connects = 1;
    for (std::size_t k = path.size() - 2;; --k) {
        sums.arrive(path.from_camera[k], 1);
        if (k == last) return sums;
        sums.leave(path.specular[k], path.from_light[k + 1], 1);
    }
}

double weight(const PathDensities& path, std::size_t s) {
    const std::size_t n = path.size();
    if (s == 0)
        return 1 / (1 + from_camera(path, 0).others_at_light(path.light_sample / path.from_camera[0],
                                                             path.from_light[0], path.from_light[1]));
    double others = 0;
    if (s == 1) {
        others = (path.can_be_hit ? std::pow(path.from_camera[0] / path.light_sample, 2) : 0) +
                 std::pow(path.from_light[0] / path.light_sample, 2) *
                     from_camera(path, 1).others(path.from_light[1], n > 3 ? path.from_light[2] : 1);
        return 1 / (1 + others);
    }
    others = from_light(path, s - 1).others(path.from_camera[s - 1], path.from_camera[s - 2]);
    if (s < n - 1) others += from_camera(path, s).others(path.from_light[s], s + 2 < n ? path.from_light[s + 1] : 1);
    return 1 / (1 + others);
}

}  // namespace

TEST_CASE("the weights of all strategies of a path sum to 1, at lengths of 2 to 256 segments", "[bdpt][mis][gate]") {
    Random random(41);
    for (const bool with_specular : {false, true})
        for (const double spread : {0.5, 4.0, 12.0})
            for (const std::size_t n : {3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 19, 29, 44, 67, 101, 152, 229, 256, 257})
                for (int repeat = 0; repeat < 20; ++repeat) {
                    const PathDensities path = random_path(random, n, spread, with_specular);
                    double largest = -1e300;
                    for (std::size_t s = 0; s < n; ++s)
                        if (path.connects(s)) largest = std::max(largest, path.density(s));
                    if (largest == -1e300) continue;
                    double all = 0, sum = 0;
                    for (std::size_t s = 0; s < n; ++s)
                        if (path.connects(s)) all += std::exp(2 * (path.density(s) - largest));
                    for (std::size_t s = 0; s < n; ++s) {
                        if (!path.connects(s)) continue;
                        const double expected = std::exp(2 * (path.density(s) - largest)) / all, w = weight(path, s);
                        CAPTURE(with_specular, spread, n, s);
                        // Products of up to n ratios, each rounded a few times.
                        CHECK(w == Approx(expected).epsilon(1e-13 * static_cast<double>(8 * n)).margin(1e-60));
                        sum += w;
                    }
                    CHECK(sum == Approx(1).margin(1e-11));
                }
}

TEST_CASE("weights stay exact where the sums of a side leave the range of double and come back", "[bdpt][mis]") {
    // Ratios of e^24 towards one end, then of e^-24: halfway the products of their squares are e^(48 x 600) = 1e12500.
    constexpr std::size_t half = 600;
    PathDensities path;
    for (std::size_t i = 0; i < 2 * half; ++i) {
        path.from_light.push_back(i < half ? 1e-6 : 1e5);
        path.from_camera.push_back(i < half ? 1e5 : i + 1 == 2 * half ? 1 : 1e-6);
        path.specular.push_back(false);
    }
    double largest = -1e300, all = 0;
    for (std::size_t s = 0; s < path.size(); ++s) largest = std::max(largest, path.density(s));
    for (std::size_t s = 0; s < path.size(); ++s) all += std::exp(2 * (path.density(s) - largest));
    for (std::size_t s = 0; s < path.size(); ++s) {
        CAPTURE(s);
        // Up to 1,200 logarithms of about 12 are added: each rounds at 2^-53 of a sum of up to 14,000.
        CHECK(weight(path, s) == Approx(std::exp(2 * (path.density(s) - largest)) / all).epsilon(1e-8).margin(1e-60));
    }
}

TEST_CASE("a cutout that a subpath passes leaves no trace in its weights", "[bdpt][mis]") {
    PartialMisWeights over_cutout, direct;
    for (PartialMisWeights* weights : {&over_cutout, &direct}) {
        weights->connects = 1;
        weights->arrive(3, 0.5);
        weights->leave(false, 0.25, 0.75);
        if (weights == &over_cutout) weights->arrive(7, 4);
        weights->arrive(2, 0.125);
    }
    CHECK(over_cutout.others(5, 6) == direct.others(5, 6));
    over_cutout.leave(false, 0.5, 1);
    direct.leave(false, 0.5, 1);
    over_cutout.arrive(1, 1);
    direct.arrive(1, 1);
    CHECK(over_cutout.others(5, 6) == direct.others(5, 6));
}

TEST_CASE("densities of zero and beyond all range leave weights that are numbers", "[bdpt][mis]") {
    for (const double tiny : {0.0, 1e-300, 1e-30})
        for (const double huge : {1e30, 1e300}) {
            PartialMisWeights sums;
            sums.connects = 1;
            for (int i = 0; i < 300; ++i) {
                sums.arrive(i % 2 == 0 ? tiny : huge, huge);
                const double others = sums.others(i % 3 == 0 ? 0 : huge, huge);
                CHECK(others >= 0);
                CHECK(std::isfinite(others));
                CHECK(std::isfinite(sums.others_at_light(huge, huge, huge)));
                sums.leave(i % 5 == 0, i % 7 == 0 ? 0 : huge, 1);
            }
        }
}
