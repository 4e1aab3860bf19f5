#include "transport/paths/subpaths/light_subpaths.h"

#include <cmath>

#include "transport/paths/subpaths/live_lights.h"
#include "transport/paths/subpaths/transmittance.h"

namespace raylex::transport {

LightEmitters::LightEmitters(const PathContext& context, std::uint32_t max_depth) {
    const EventTable& events = *context.events;
    if (events.any()) language_ = std::make_shared<const LightLanguage>(*context.services.lpe, events);
    chooser_ = choose_live_lights(context.scene, events, language(), LightChoice::light_sampling,
                                  &display::SuffixLiveness::LiveSet::goes_on);
    any_ = max_depth > 0 && !chooser_.empty() && (context.beauty || events.any());
    none_is_live_ = !any_ && max_depth > 0 && !context.scene.lights->lights().empty();
    const Vec3 middle_of_lens = context.view.camera->generate({0, 0, {0.5f, 0.5f}}).origin;
    if (any_) media_ = media_of_lights(context.scene, middle_of_lens);
}

LightSubpaths::LightSubpaths(const PathContext& context, const LightEmitters& emitters, const WalkOptions& options)
    : Walk(context, options,
           LightRecord(*context.events, emitters.language(), static_cast<std::size_t>(context.batch_capacity))),
      emitters_(emitters) {
    origins_.resize(paths_.size());
}

void LightSubpaths::begin(const CameraBatch& batch, ThreadServices& services, IntegratorCounters& counters) {
    Walk::begin(batch.samplers, counters);
    if (!emitters_.any()) return counters.count(Pruned::light_paths, emitters_.none_is_live() ? batch.rays.size() : 0);
    record_.begin(services.lpe);
    const LightTable& lights = *scene_.lights;
    const LightChooser& chooser = emitters_.chooser();
    const bool own_choice = chooser.needs_number();
    for (std::size_t i = 0; i < batch.samplers.size(); ++i) {
        const auto row = static_cast<std::uint32_t>(i);
        const PixelSampler& numbers = batch.samplers[i];
        paths_[row] = Subpath();
        EmissionSample s;
        if (lights.sample_emission(chooser, *scene_.geometry,
                                   own_choice ? numbers.get_1d(light_dimensions + emitter_dimension) : 0.0f,
                                   numbers.get_2d(light_dimensions + origin_dimension),
                                   numbers.get_2d(light_dimensions + direction_dimension), s))
            start(row, s, batch.rays[i].time);
        else counters.count_length(0);
    }
}

void LightSubpaths::start(std::uint32_t row, const EmissionSample& s, Real time) {
    Subpath& path = paths_[row];
    const Light& light = scene_.lights->lights()[s.from.light];
    Rgb power = s.power;
    if (!s.from.infinite) power *= emitter_opacity(scene_, s.from, s.from.target + s.direction);
    if (!emitters_.media().empty()) {
        path.medium = emitters_.media()[s.from.light];
        if (light.is_area())
            path.medium =
                scene_.geometry->shapes()[light.shape].medium_towards(s.from.target_normal, s.direction, path.medium);
        else if (s.from.infinite && path.medium >= 0) power *= from_infinity(row, s);
    }
    path.beta = power;
    path.roulette_scale = power.max();
    origins_[row] = s.from;
    path.specular = false;
    path.from = light.is_area() ? s.from.target : s.origin;
    record_.leave_light(row, s.from.light);
    if (power.is_black()) return finish(row);
    if (!record_.is_live(row)) {
        counters().count(Pruned::light_paths);
        return finish(row);
    }
    if (options_.densities) {
        const EmissionDensity density =
            scene_.lights->emission_density(emitters_.chooser(), *scene_.geometry, s.from, s.direction);
        path.pdf = density.direction;
        PartialMisWeights& mis_weights = mis_weights_[row];
        mis_weights = PartialMisWeights();
        mis_weights.previous = static_cast<double>(density.position);
        if (light.is_area()) mis_weights.cosine = static_cast<double>(std::abs(dot(s.from.target_normal, s.direction)));
        mis_weights.tail = light.is_delta() ? 0 : 1;  // camera subpaths find what is not a delta light by themselves
    }
    Ray ray;
    ray.origin = s.origin;
    ray.direction = s.direction;
    ray.time = time;
    push(row, ray);
}

/// The part of light from infinitely far away that the medium lets pass to the point where its ray begins.
Rgb LightSubpaths::from_infinity(std::uint32_t row, const EmissionSample& s) const {
    const Medium& medium = (*scene_.media)[paths_[row].medium];
    if (medium.grid == nullptr) return transmittance(medium, infinity);
    const FlightNumbers numbers(sampler(row).key(dimensions.connections), 1);
    return medium.grid->transmittance({s.origin, -s.direction, infinity}, numbers);
}

bool LightSubpaths::advance(ThreadServices& services) {
    if (!going() || services.leaving()) return false;
    Walk::advance(services.display);
    return true;
}

LightSubpathVertex LightSubpaths::vertex(std::size_t j) const {
    const VertexBatch& v = vertices_;
    const std::uint32_t row = v.rows[j];
    const EmbreeScene& geometry = *scene_.geometry;
    LightSubpathVertex vertex;
    vertex.row = row;
    vertex.depth = path(row).depth;
    vertex.length = vertex_depth(j);
    vertex.offset = v.sources[j].offset;
    vertex.holdout = j < v.surfaces && geometry.has_holdouts() && geometry.is_holdout(v.hits[j]);
    vertex.power = path(row).beta;
    vertex.one_wavelength = path(row).one_wavelength;
    vertex.end = record_.end(row, v.sources[j].label);
    vertex.live = record_.live_set(row, v.sources[j].label, v.points[j].material);
    vertex.time = v.hits[j].time;
    vertex.key = scene_.media->any_grids() ? sampler(row).key(dimensions.connections + vertex.depth) : 0;
    if (options_.densities) vertex.mis_weights = mis_weights_[row];
    vertex.weighted = options_.densities;
    return vertex;
}

}  // namespace raylex::transport
