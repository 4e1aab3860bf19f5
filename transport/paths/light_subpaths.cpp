#include "transport/paths/light_subpaths.h"

#include <cmath>

#include "transport/paths/transmittance.h"
#include "transport/paths/walk.h"

namespace raylex::transport {

LightSubpaths::LightSubpaths(const SceneView& scene, const LightSubpathOptions& options, std::size_t capacity)
    : scene_(scene), options_(options), paths_(capacity), words_(capacity) {
    if (options.densities) densities_.resize(capacity);
    queue_.reserve(capacity);
    vertices_.reserve(capacity);
}

void LightSubpaths::begin(std::span<const PixelSampler> samplers, IntegratorCounters& counters) {
    queue_.count = 0;
    const LightTable& lights = *scene_.lights;
    const bool own_choice = lights.needs_choice_number(LightChoice::light_sampling);
    for (std::size_t i = 0; i < samplers.size(); ++i) {
        const auto row = static_cast<std::uint32_t>(i);
        const PixelSampler& sampler = samplers[i];
        LightSubpath& path = paths_[row];
        path = LightSubpath();
        words_[row].clear();
        EmissionSample s;
        if (!lights.sample_emission(*scene_.geometry,
                                    own_choice ? sampler.get_1d(light_dimensions + emitter_dimension) : 0.0f,
                                    sampler.get_2d(light_dimensions + origin_dimension),
                                    sampler.get_2d(light_dimensions + direction_dimension), s)) {
            counters.count_length(0);
            continue;
        }
        if (!s.from.infinite) s.power *= emitter_opacity(scene_, s.from, s.from.target + s.direction);
        path.power = s.power;
        path.start_power = s.power.max();
        path.light = s.from.light;
        if (s.power.is_black()) {
            counters.count_length(0);
            continue;
        }
        if (options_.densities) begin_densities(row, s);
        Ray ray;
        ray.origin = s.origin;
        ray.direction = s.direction;
        queue_.push(row, ray);
    }
    counters.scattering_rays += queue_.count;
}

void LightSubpaths::begin_densities(std::uint32_t row, const EmissionSample& s) {
    const Light& light = scene_.lights->lights()[s.from.light];
    const EmissionDensity density = scene_.lights->emission_density(*scene_.geometry, s.from, s.direction);
    Densities& d = densities_[row];
    d = Densities();
    d.origin = s.from;
    d.from = s.origin;
    if (light.is_area()) {
        d.from = s.from.target;
        d.cosine = std::abs(dot(s.from.target_normal, s.direction));
    }
    d.pdf = density.direction;
    d.from_infinity = s.from.infinite;
    // Camera subpaths find what is not a delta light by themselves.
    d.sums.previous = static_cast<double>(density.position);
    d.sums.tail = light.is_delta() ? 0 : 1;
}

void LightSubpaths::arrive(std::uint32_t row, const SurfacePoint& point) {
    Densities& d = densities_[row];
    const double cosine = std::abs(dot(point.geometric_normal, point.wo));
    const double near = d.from_infinity ? 1 : 1 / static_cast<double>(length_squared(point.position - d.from));
    const double to_previous = d.from_infinity ? 1 : static_cast<double>(d.cosine) * near;
    d.sums.arrive(static_cast<double>(d.pdf) * cosine * near, to_previous);
    if (d.at_light) {
        // The strategy that joins at the light has the density of a light sample and not of an emission.
        const Light& light = scene_.lights->lights()[d.origin.light];
        const double sampled = static_cast<double>(
            scene_.lights->density(options_.sampled_by, *scene_.geometry, point.position, d.origin));
        d.sums.join = StrategySums::squared(sampled * (light.is_area() ? to_previous : 1) / d.sums.previous);
        d.at_light = false;
    }
    d.from_infinity = false;
}

void LightSubpaths::advance(std::span<const PixelSampler> samplers, IntegratorCounters& counters,
                            display::DisplayServices& display) {
    trace(*scene_.geometry, queue_, vertices_, [&](std::uint32_t row, const Ray&, const Hit& hit) {
        if (!hit.valid()) counters.count_length(paths_[row].depth);
        return hit.valid();
    });
    const bool cutouts = scene_.geometry->has_alpha();
    std::size_t kept = 0;
    for (std::size_t j = 0; j < vertices_.count; ++j) {
        const std::uint32_t row = vertices_.rows[j];
        if (cutouts && passes_cutout(j, samplers[row])) continue;
        vertices_.points[j].random_key = samplers[row].key(light_subpath_dimension(paths_[row].depth, light_key_dimension));
        vertices_.points[j].row = -1;
        if (options_.densities) arrive(row, vertices_.points[j]);
        vertices_.keep(j, kept++);
    }
    vertices_.count = kept;
    counters.scattering_rays += queue_.count;
    if (kept > 0)
        scene_.materials->shade(*scene_.textures, {vertices_.points.data(), kept}, {vertices_.bsdfs.data(), kept},
                                &display);
}

bool LightSubpaths::passes_cutout(std::size_t j, const PixelSampler& sampler) {
    if (scene_.geometry->shapes()[vertices_.hits[j].shape].alpha < 0) return false;
    const std::uint32_t row = vertices_.rows[j];
    LightSubpath& path = paths_[row];
    if (!passes_alpha_test(scene_, vertices_, j, sampler.get_random(light_cutout_dimensions + path.segment)))
        return false;
    if (options_.words) words_[row].push_back({vertices_.sources[j].label, true, {}});
    ++path.segment;
    queue_.push(row, ray_from(vertices_, j, vertices_.rays[j].direction));
    return true;
}

bool LightSubpaths::survives_roulette(LightSubpath& path, const PixelSampler& sampler,
                                      std::uint32_t dimension) const {
    if (!options_.roulette || path.depth < 2) return true;
    const float keep = path.power.max() / path.start_power;
    if (!(keep < 1)) return true;
    if (sampler.get_random(dimension) >= keep) return false;
    path.power *= 1 / keep;
    return true;
}

bool LightSubpaths::scatter(std::size_t j, std::span<const PixelSampler> samplers, IntegratorCounters& counters) {
    const std::uint32_t row = vertices_.rows[j];
    LightSubpath& path = paths_[row];
    const std::uint32_t depth = path.depth++;
    const Bsdf& bsdf = vertices_.bsdfs[j];
    const SurfacePoint& point = vertices_.points[j];
    const auto finish = [&] { counters.count_length(path.depth); };
    if (path.depth >= options_.max_depth) {  // the scattering towards the camera was its last
        finish();
        return true;
    }
    const PixelSampler& sampler = samplers[row];
    const bool plain = bsdf.kind() == Bsdf::Kind::lambert;
    const Scattering s = sample_scattering(TransportMode::importance, bsdf, point,
                                           plain ? 0.0f : sampler.get_1d(light_subpath_dimension(depth, light_lobe_dimension)),
                                           sampler.get_2d(light_subpath_dimension(depth, light_scatter_dimension)));
    if (!(s.pdf > 0)) {
        --path.depth;
        finish();
        return true;
    }
    path.power *= s.weight;
    ++path.segment;
    if (!is_finite(path.power)) {
        finish();
        return false;
    }
    if (path.power.is_black() ||
        !survives_roulette(path, sampler, light_subpath_dimension(depth, light_roulette_dimension))) {
        finish();
        return true;
    }
    if (options_.words) words_[row].push_back({vertices_.sources[j].label, false, s.lobes});
    if (options_.densities) {
        Densities& d = densities_[row];
        d.sums.leave(s.specular, s.specular ? 1.0 : static_cast<double>(bsdf.pdf(s.wi, point.wo)));
        d.pdf = s.specular ? 1.0f : s.pdf;
        d.from = point.position;
        d.cosine = std::abs(dot(point.geometric_normal, s.wi));
    }
    queue_.push(row, ray_from(vertices_, j, s.wi));
    ++counters.scattering_rays;
    return true;
}

}  // namespace raylex::transport
