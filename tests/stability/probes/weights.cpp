// Weights of multiple importance sampling, which sum to 1 for any densities.
#include <cmath>
#include <vector>

#include "display/services/elementary.h"
#include "tests/stability/probes/counted_numbers.h"
#include "tests/stability/probes/probes.h"
#include "transport/math/sampling.h"
#include "transport/paths/partial_mis_weights.h"

namespace raylex::experiments {
namespace {

using transport::PartialMisWeights;
using transport::Real;

Result<ProbeResult> power_heuristic_sum(const ProbeInput& input) {
    const auto a = static_cast<Real>(input.number("a")), b = static_cast<Real>(input.number("b"));
    if (Status given = input.status(); !given) return given.error();
    ProbeResult result;
    result.measured = double(transport::power_heuristic(a, b)) + double(transport::power_heuristic(b, a));
    result.expected = a > 0 || b > 0 ? 1 : 0;  // a sample that no strategy makes has no weight
    return result;
}

/// Densities per area of the vertices of a path, from the light (0) to the camera (last).
struct PathDensities {
    std::vector<double> from_light, from_camera;
    std::vector<bool> specular;
    double light_sample = 1;  ///< density of vertex 0 by light sampling

    [[nodiscard]] std::size_t size() const { return specular.size(); }
    [[nodiscard]] bool connects(std::size_t s) const {
        return s == 0 || (s < size() && !specular[s - 1] && !specular[s]);
    }
};

/// Returns densities spread from e^-spread to e^spread.
PathDensities random_path(CountedNumbers& numbers, std::size_t vertices, double spread, double specular) {
    PathDensities path;
    const auto density = [&] { return elementary::exp(spread * (2 * numbers.one() - 1)); };
    for (std::size_t i = 0; i < vertices; ++i) {
        path.from_light.push_back(density());
        path.from_camera.push_back(i + 1 == vertices ? 1 : density());
        path.specular.push_back(i > 0 && i + 1 < vertices && numbers.one() < specular);
    }
    path.light_sample = density();
    return path;
}

/// Returns the sums at the light subpath's vertex `last`, made vertex by vertex as in a walk.
PartialMisWeights from_light(const PathDensities& path, std::size_t last) {
    PartialMisWeights sums;
    sums.previous = path.from_light[0];
    sums.tail = 1;  // the light can be hit
    for (std::size_t k = 1; k <= last; ++k) {
        sums.arrive(path.from_light[k], 1);
        if (k == 1) {
            const double ratio = path.light_sample / path.from_light[0];
            sums.connects = ratio * ratio;
        }
        if (k < last) sums.leave(path.specular[k], path.from_camera[k - 1], 1);
    }
    return sums;
}

/// Returns the sums at the camera subpath's vertex `last`, counted from the light.
PartialMisWeights from_camera(const PathDensities& path, std::size_t last) {
    PartialMisWeights sums;
    sums.connects = 1;
    for (std::size_t k = path.size() - 2;; --k) {
        sums.arrive(path.from_camera[k], 1);
        if (k == last) return sums;
        sums.leave(path.specular[k], path.from_light[k + 1], 1);
    }
}

/// Returns the weight of the strategy with s vertices from the light.
double weight(const PathDensities& path, std::size_t s) {
    const std::size_t n = path.size();
    double others = 0;
    if (s == 0) {
        others = from_camera(path, 0).others_at_light(path.light_sample / path.from_camera[0], path.from_light[0],
                                                      path.from_light[1]);
    } else if (s == 1) {
        const double hit = PartialMisWeights::squared(path.from_camera[0] / path.light_sample),
                     emitted = PartialMisWeights::squared(path.from_light[0] / path.light_sample);
        others = hit + emitted * from_camera(path, 1).others(path.from_light[1], n > 3 ? path.from_light[2] : 1);
    } else {
        others = from_light(path, s - 1).others(path.from_camera[s - 1], path.from_camera[s - 2]);
        if (s < n - 1)
            others += from_camera(path, s).others(path.from_light[s], s + 2 < n ? path.from_light[s + 1] : 1);
    }
    return static_cast<double>(1 / (1 + others));
}

/// Returns the sum that is farthest from 1, over some paths.
Result<ProbeResult> strategy_weights_sum(const ProbeInput& input) {
    const auto segments = static_cast<std::size_t>(input.number("segments"));
    const double spread = input.number("spread"), specular = input.number("specular", 0);
    CountedNumbers numbers(static_cast<std::uint64_t>(input.number("seed", 1)));
    if (Status given = input.status(); !given) return given.error();
    if (segments < 2) return error_at(input.where(), "'segments' is below 2; such a path has only one strategy");
    ProbeResult result;
    result.measured = result.expected.emplace(1);
    for (int repeat = 0; repeat < 10; ++repeat) {
        const PathDensities path = random_path(numbers, segments + 1, spread, specular);
        double sum = 0;
        for (std::size_t s = 0; s < path.size(); ++s)
            if (path.connects(s)) sum += weight(path, s);
        if (!(std::abs(sum - 1) <= std::abs(result.measured - 1))) result.measured = sum;
    }
    return result;
}

}  // namespace

std::span<const NamedProbe> weight_probes() {
    static constexpr NamedProbe table[] = {
        {"power_heuristic_sum", "sum of the two weights of a sample with densities a and b", power_heuristic_sum},
        {"strategy_weights_sum",
         "sum of the weights of all bidirectional strategies of a path, worst of ten paths; segments, spread "
         "(densities lie within e^-spread and e^spread), specular (probability of a vertex), seed",
         strategy_weights_sum}};
    return table;
}

}  // namespace raylex::experiments
