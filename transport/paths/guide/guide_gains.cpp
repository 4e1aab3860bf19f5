#include "transport/paths/guide/guide_gains.h"

#include <algorithm>
#include <cmath>

namespace raylex::transport {
namespace {

// Each region has so many departures of the mean over all regions beside its own: where few paths have found light,
// others may.
constexpr double common_departures = 64;

// Of a light sample and its shadow ray, in rays and what they cost at their vertices.
constexpr double light_sample_cost = 0.5;

// While a guide learns: where it has found nothing yet, other paths may find light.
constexpr Real training_survival = Real(0.25);

constexpr double light_unit = 0x1p20;
/// A sum of 2^23 values stays below 2^63.
std::uint64_t in_light_units(double value) {
    constexpr double most = 0x1p20;
    return value > 0 ? static_cast<std::uint64_t>(std::min(value, most) * light_unit + 0.5) : 0;
}

double sum_of(const std::atomic<std::uint64_t>& sum) {
    return static_cast<double>(sum.load(std::memory_order_relaxed));
}

}  // namespace

Real rays_by_gain(const GuideTree::Region& region, Real throughput, bool training) {
    const auto rays = [training](Real m) { return training ? std::sqrt(m) : m; };
    const Real by_square = throughput * region.by_square;
    if (by_square < 1) return std::max(rays(by_square), training ? training_survival : least_survival);
    return std::clamp(rays(throughput * region.by_noise), Real(1), most_branches);
}

Real light_share_by_gain(const GuideTree::Region& region, Real throughput) {
    return std::clamp(throughput * region.by_light, least_survival, Real(1));
}

void LaterLight::add(double light, std::uint64_t rays_of_path) {
    sum += light;
    squares += light * light;
    rays += rays_of_path;
}

void LaterLight::end_pixel(double samples) {
    // The square of the mean, from products of different samples alone.
    variance += squares - (samples > 1 ? (sum * sum - squares) / (samples - 1) : 0);
    sum = squares = 0;
}

void GainSums::add(const LaterRadiance::Path& path, LaterLight& later) {
    double found = 0;
    bool scattered = false;
    for (std::size_t i = 0; i < path.vertices.size(); ++i) {
        const PassedVertex& v = path.vertices[i];
        if (!v.specular && !scattered) {
            found = (path.received[0] - path.before(i, 0)) / mean_;
            scattered = true;
        }
        std::size_t end = i + 1;
        while (end < path.vertices.size() && path.vertices[end].depth > v.depth) ++end;
        Region& sums = regions_[tree_.place_of(v.position, v.normal).region];
        sums.departures.fetch_add(1, std::memory_order_relaxed);
        sums.rays.fetch_add(end - i, std::memory_order_relaxed);
        // Before the first ray leaves a vertex, the channel receives what the light sample there has found, and light
        // that surfaces emit at the vertex and media before it. So light samples in emitting media seem to find more.
        const bool first = i == 0 || v.depth == path.vertices[i - 1].depth + 1;
        if (first && !v.specular && !v.emits) {
            sums.vertices.fetch_add(1, std::memory_order_relaxed);
            const double sampled =
                (path.before(i, 0) - (i == 0 ? 0 : path.before(i - 1, 0))) / (static_cast<double>(v.reached) * mean_);
            sums.sampled.fetch_add(in_light_units(sampled * sampled), std::memory_order_relaxed);
        }
        const double light = path.behind(i, 0) / (static_cast<double>(v.arrived) * mean_);
        if (!(light > 0)) continue;
        sums.light.fetch_add(in_light_units(light), std::memory_order_relaxed);
        sums.squares.fetch_add(in_light_units(light * light), std::memory_order_relaxed);
    }
    later.add(found, 1 + path.vertices.size());
}

void GainSums::set_gains(GuideTree& refined, const LaterLight& of_paths) const {
    double departures = 0, rays = 0, light = 0, squares = 0, vertices = 0, sampled = 0;
    for (const Region& region : regions_) {
        departures += sum_of(region.departures);
        rays += sum_of(region.rays);
        light += sum_of(region.light);
        squares += sum_of(region.squares);
        vertices += sum_of(region.vertices);
        sampled += sum_of(region.sampled);
    }
    if (!(squares > 0 && of_paths.variance > 0)) return;
    const double common = common_departures / departures;
    constexpr float all_samples = 1e30f;
    const double efficiency = static_cast<double>(of_paths.rays) / of_paths.variance;
    for (std::size_t i = 0; i < refined.regions().size(); ++i) {
        const Region& region = regions_[refined.regions()[i].before];
        const double count = (sum_of(region.departures) + common_departures) * light_unit;
        const double mean = (sum_of(region.light) + common * light) / count,
                     square = (sum_of(region.squares) + common * squares) / count,
                     cost = (sum_of(region.rays) + common * rays) * light_unit / count;
        const double by_sample = (sum_of(region.sampled) + common_departures * sampled / std::max(vertices, 1.0)) /
                                 ((sum_of(region.vertices) + common_departures) * light_unit * light_sample_cost);
        refined.set_gain(i, static_cast<float>(std::sqrt(square / cost * efficiency)),
                         static_cast<float>(std::sqrt(std::max(0.0, square - mean * mean) / cost * efficiency)),
                         vertices > 0 ? static_cast<float>(std::sqrt(by_sample * efficiency)) : all_samples);
    }
}

}  // namespace raylex::transport
