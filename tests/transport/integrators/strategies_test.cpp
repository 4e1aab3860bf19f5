// The weights of all bidirectional strategies of a path: they sum to 1, and each is what its densities say.
#include <catch2/catch.hpp>

#include <cmath>
#include <vector>

#include "tests/transport/materials_support.h"
#include "transport/paths/strategies.h"

using raylex::test::Random;
using raylex::transport::StrategySums;

namespace {

/// Vertices from the light (0) to the camera (last).
struct PathDensities {
    std::vector<double> from_light, from_camera;  // of each vertex, per area
    std::vector<bool> specular;
    double light_sample = 1;  // of vertex 0 as light sampling finds it
    bool can_be_hit = true;

    [[nodiscard]] std::size_t size() const { return specular.size(); }
    [[nodiscard]] bool joins(std::size_t s) const {
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
StrategySums from_light(const PathDensities& path, std::size_t last) {
    StrategySums sums;
    sums.previous = path.from_light[0];
    sums.tail = path.can_be_hit ? 1 : 0;
    for (std::size_t k = 1; k <= last; ++k) {
        sums.arrive(path.from_light[k], 1);
        if (k == 1) sums.join = std::pow(path.light_sample / path.from_light[0], 2);
        if (k < last) sums.leave(path.specular[k], path.from_camera[k - 1]);
    }
    return sums;
}

/// Sums at the camera subpath's vertex `last`, counted from the light.
StrategySums from_camera(const PathDensities& path, std::size_t last) {
    StrategySums sums;
    sums.join = 1;
    for (std::size_t k = path.size() - 2;; --k) {
        sums.arrive(path.from_camera[k], 1);
        if (k == last) return sums;
        sums.leave(path.specular[k], path.from_light[k + 1]);
    }
}

long double weight(const PathDensities& path, std::size_t s) {
    const std::size_t n = path.size();
    if (s == 0)
        return 1 / (1 + from_camera(path, 0).others_at_light(path.light_sample / path.from_camera[0],
                                                             path.from_light[0], path.from_light[1]));
    StrategySums::Wide others = 0;
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

TEST_CASE("the weights of all strategies of a path sum to 1, at lengths of 2 to 256 segments", "[bdpt][mis]") {
    Random random(41);
    for (const bool with_specular : {false, true})
        for (const double spread : {0.5, 4.0, 12.0})
            for (const std::size_t n : {3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 19, 29, 44, 67, 101, 152, 229, 256, 257})
                for (int repeat = 0; repeat < 20; ++repeat) {
                    const PathDensities path = random_path(random, n, spread, with_specular);
                    double largest = -1e300;
                    for (std::size_t s = 0; s < n; ++s)
                        if (path.joins(s)) largest = std::max(largest, path.density(s));
                    if (largest == -1e300) continue;
                    double all = 0, sum = 0;
                    for (std::size_t s = 0; s < n; ++s)
                        if (path.joins(s)) all += std::exp(2 * (path.density(s) - largest));
                    for (std::size_t s = 0; s < n; ++s) {
                        if (!path.joins(s)) continue;
                        const double expected = std::exp(2 * (path.density(s) - largest)) / all,
                                     w = static_cast<double>(weight(path, s));
                        CAPTURE(with_specular, spread, n, s);
                        // Products of up to n ratios, each rounded a few times.
                        CHECK(w == Approx(expected).epsilon(1e-13 * static_cast<double>(8 * n)).margin(1e-60));
                        sum += w;
                    }
                    CHECK(sum == Approx(1).margin(1e-11));
                }
}

TEST_CASE("densities of zero and beyond all range leave weights that are numbers", "[bdpt][mis]") {
    for (const double tiny : {0.0, 1e-300, 1e-30})
        for (const double huge : {1e30, 1e300}) {
            StrategySums sums;
            sums.join = 1;
            for (int i = 0; i < 300; ++i) {
                sums.arrive(i % 2 == 0 ? tiny : huge, huge);
                const StrategySums::Wide others = sums.others(i % 3 == 0 ? 0 : huge, huge);
                CHECK(others >= 0);
                CHECK(std::isfinite(others));
                CHECK(std::isfinite(sums.others_at_light(huge, huge, huge)));
                sums.leave(i % 5 == 0, i % 7 == 0 ? 0 : huge);
            }
        }
}
