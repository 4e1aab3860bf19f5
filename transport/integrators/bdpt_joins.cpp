// Where bidirectional path tracing's subpaths meet: lights found, light samples, joined vertices, the camera.
#include <cmath>

#include "transport/integrators/bdpt_state.h"
#include "transport/paths/transmittance.h"

namespace raylex::transport {

void Bdpt::add_found(BdptThread& thread, ThreadServices& services, std::uint32_t row, const Rgb& emitted,
                     const LightSample& at, float sampled, const Vec3& towards) const {
    const CameraSubpath& path = thread.paths[row];
    float weight = 1;
    if (path.depth > 0) {  // what the camera sees directly is found in no other way
        const EmissionDensity emission =
            can_emit_ ? context_.scene.lights->emission_density(*context_.scene.geometry, at, towards)
                      : EmissionDensity();
        weight = StrategySums::weight(path.sums.others_at_light(
            static_cast<double>(sampled) / static_cast<double>(path.pdf), static_cast<double>(emission.position),
            static_cast<double>(emission.direction)));
    }
    const Rgb value = path.beta * emitted * weight;
    if (value.is_black()) return;
    display::Tracker tracker = thread.trackers[row];
    services.lpe.move(tracker, context_.events->terminal(at.light));
    services.lpe.contribute(value, display::Technique::scattering, tracker);
}

void Bdpt::find_light(BdptThread& thread, ThreadServices& services, std::size_t j) const {
    const VertexBatch& v = thread.vertices;
    const std::uint32_t row = v.rows[j];
    const SurfacePoint& point = v.points[j];
    LightSample at;
    at.light = context_.scene.geometry->shapes()[v.hits[j].shape].first_light + v.hits[j].primitive;
    at.target = point.position;
    at.target_normal = point.geometric_normal;
    at.uv = {v.hits[j].u, v.hits[j].v};
    const LightTable& lights = *context_.scene.lights;
    const Rgb emitted = lights.emitted(at.light, point.geometric_normal, point.wo);
    if (emitted.is_black()) return;
    const CameraSubpath& path = thread.paths[row];
    const float sampled =
        path.depth > 0 ? lights.density(LightChoice::mis, *context_.scene.geometry, path.from, at) : 0.0f;
    add_found(thread, services, row, emitted, at, sampled, point.wo);
}

void Bdpt::find_environments(BdptThread& thread, ThreadServices& services, std::uint32_t row, const Ray& ray) const {
    const LightTable& lights = *context_.scene.lights;
    CameraSubpath& path = thread.paths[row];
    path.sums.arrive(static_cast<double>(path.pdf), static_cast<double>(path.cosine));
    for (const std::uint32_t light : lights.environments()) {
        LightSample at;
        at.light = light;
        at.infinite = true;
        at.wi = ray.direction;
        const float sampled = lights.environment_density(LightChoice::mis, light, ray.direction);
        add_found(thread, services, row, lights.environment_radiance(light, ray.direction), at, sampled,
                  -ray.direction);
    }
}

void Bdpt::sample_light(const CameraBatch& batch, BdptThread& thread, ThreadServices& services, std::size_t j) const {
    const VertexBatch& v = thread.vertices;
    const EmbreeScene& geometry = *context_.scene.geometry;
    const LightTable& lights = *context_.scene.lights;
    const std::uint32_t row = v.rows[j];
    const CameraSubpath& path = thread.paths[row];
    const PixelSampler& sampler = batch.samplers[row];
    const SurfacePoint& point = v.points[j];
    const float u_choice = lights.needs_choice_number(LightChoice::mis)
                               ? sampler.get_1d(camera_dimension(path, camera_choice_dimension))
                               : 0.0f;
    LightSample sample;
    if (!lights.sample(LightChoice::mis, geometry, point.position, u_choice,
                       sampler.get_2d(camera_dimension(path, camera_light_dimension)), sample))
        return;
    if (geometry.has_alpha()) sample.radiance *= emitter_opacity(context_.scene, sample, point.position);
    const JoinedScattering f = evaluate_scattering(TransportMode::radiance, v.bsdfs[j], point, sample.wi, true);
    if (f.value.is_black()) return;
    // The strategies beside this one: the camera subpath meets the light by itself; light subpaths begin there.
    const Light& light = lights.lights()[sample.light];
    const double pdf = static_cast<double>(sample.pdf);
    StrategySums::Wide others = light.is_delta() ? 0 : StrategySums::squared(static_cast<double>(f.pdf) / pdf);
    if (can_emit_) {
        const EmissionDensity emission = lights.emission_density(geometry, sample, -sample.wi);
        const double cosine = std::abs(dot(point.geometric_normal, sample.wi));
        const double near =
            sample.infinite ? 1 : 1 / static_cast<double>(length_squared(sample.target - point.position));
        const double light_cosine = light.is_area() ? std::abs(dot(sample.target_normal, sample.wi)) : 1;
        const double to_light = light.is_area() ? light_cosine * near : 1;
        const double begun = to_light > 0 ? static_cast<double>(emission.position) / (pdf * to_light) : 0;
        others += StrategySums::squared(begun) *
                  path.sums.others(static_cast<double>(emission.direction) * cosine * near,
                                   static_cast<double>(f.pdf_reverse));
    }
    Join join;
    join.row = row;
    join.light = sample.light;
    join.label = v.sources[j].label;
    join.lobes = f.lobes;
    join.value = path.beta * f.value * sample.radiance * (StrategySums::weight(others) / sample.pdf);
    if (join.value.is_black() || !worth_a_ray(thread, services, join)) return;
    thread.joins.push_back(join);
    thread.shadow_rays.push_back(shadow_ray(point.position, point.geometric_normal, v.sources[j].offset, sample));
}

void Bdpt::join_vertices(BdptThread& thread, ThreadServices& services, std::size_t j) const {
    const VertexBatch& v = thread.vertices;
    const std::uint32_t row = v.rows[j];
    const CameraSubpath& path = thread.paths[row];
    const SurfacePoint& point = v.points[j];
    for (std::uint32_t i = thread.last_vertex[row]; i != LightVertex::none; i = thread.light_vertices[i].previous) {
        const LightVertex& y = thread.light_vertices[i];
        if (path.depth + y.depth + 2 > parameters_.max_depth) continue;
        const Vec3 between = y.point.position - point.position;
        const float d2 = length_squared(between);
        if (!(d2 > 0)) continue;
        const Vec3 direction = between / std::sqrt(d2);
        const JoinedScattering f = evaluate_scattering(TransportMode::radiance, v.bsdfs[j], point, direction, true);
        if (f.value.is_black()) continue;
        const JoinedScattering g = evaluate_scattering(TransportMode::importance, y.bsdf, y.point, -direction, true);
        if (g.value.is_black()) continue;
        const double near = 1 / static_cast<double>(d2);
        const double at_camera = std::abs(dot(point.geometric_normal, direction)) * near,
                     at_light = std::abs(dot(y.point.geometric_normal, direction)) * near;
        const StrategySums::Wide others =
            path.sums.others(static_cast<double>(g.pdf) * at_camera, static_cast<double>(f.pdf_reverse)) +
            y.sums.others(static_cast<double>(f.pdf) * at_light, static_cast<double>(g.pdf_reverse));
        Join join;
        join.row = row;
        join.vertex = i;
        join.light = y.light;
        join.label = v.sources[j].label;
        join.lobes = f.lobes;
        join.light_lobes = g.lobes;
        join.value = path.beta * f.value * g.value * y.power * (StrategySums::weight(others) / d2);
        if (join.value.is_black() || !worth_a_ray(thread, services, join)) continue;
        Ray ray;
        ray.origin = offset_ray_origin(point.position, point.geometric_normal, v.sources[j].offset, direction);
        ray.direction =
            offset_ray_origin(y.point.position, y.point.geometric_normal, y.offset, -direction) - ray.origin;
        ray.t_max = shadow_t_max;
        thread.joins.push_back(join);
        thread.shadow_rays.push_back(ray);
    }
}

bool Bdpt::worth_a_ray(const BdptThread& thread, ThreadServices& services, const Join& join) const {
    const display::Tracker& tracker = thread.trackers[join.row];
    if (services.lpe.takes_all(tracker) || context_.scene.geometry->has_alpha()) return true;
    display::Tracker ahead = tracker;
    move_by_lobes(ahead, services.lpe, *context_.events, join.label, join.lobes);
    if (join.vertex == LightVertex::none) return services.lpe.live_after(ahead, context_.events->terminal(join.light));
    const LightVertex& y = thread.light_vertices[join.vertex];
    move_by_lobes(ahead, services.lpe, *context_.events, y.label, join.light_lobes);
    move_to_light(ahead, services.lpe, *context_.events, word_of(thread, y), y.light);
    return services.lpe.live(ahead);
}

void Bdpt::add_joins(BdptThread& thread, ThreadServices& services) const {
    const std::size_t count = thread.joins.size();
    const EmbreeScene& geometry = *context_.scene.geometry;
    const EventTable& events = *context_.events;
    thread.counters.shadow_rays += count;
    thread.blocked.resize(std::max(thread.blocked.size(), count));
    geometry.occluded(thread.shadow_rays, {thread.blocked.data(), count});
    for (std::size_t i = 0; i < count; ++i) {
        if (thread.blocked[i]) continue;
        const Join& join = thread.joins[i];
        display::Tracker tracker = thread.trackers[join.row];
        move_by_lobes(tracker, services.lpe, events, join.label, join.lobes);
        Rgb value = join.value, through(1);
        if (geometry.has_alpha()) {
            const float visible =
                straight_transmittance({context_.scene, events, services.lpe, thread.counters}, thread.shadow_rays[i],
                                       1, -1, tracker, through);
            if (!(visible > 0)) continue;
            value *= visible;
        }
        if (join.vertex == LightVertex::none) {
            services.lpe.move(tracker, events.terminal(join.light));
            services.lpe.contribute(value, display::Technique::light_sampling, tracker);
            continue;
        }
        const LightVertex& y = thread.light_vertices[join.vertex];
        if (events.any()) {
            move_by_lobes(tracker, services.lpe, events, y.label, join.light_lobes);
            move_to_light(tracker, services.lpe, events, word_of(thread, y), y.light);
        }
        services.lpe.contribute(value, display::Technique::connection, tracker);
    }
}

void Bdpt::connect_to_camera(const CameraBatch& batch, BdptThread& thread, ThreadServices& services) const {
    for (const LightVertex& y : thread.light_vertices) {
        const Vec2 lens = context_.camera->has_lens()
                              ? batch.samplers[y.row].get_2d(light_subpath_dimension(y.depth, camera_lens_dimension))
                              : Vec2{0, 0};
        thread.connections.add(view_, {y.row, y.light, &y.point, &y.bsdf, y.offset, y.label, y.power,
                                       word_of(thread, y), &y.sums}, lens);
    }
    if (!context_.beauty && !context_.scene.geometry->has_alpha())
        thread.connections.drop_dead(*context_.events, services.lpe);
    thread.connections.splat(context_.scene, *context_.events, batch.rows, *services.raster, thread.counters);
    for (const auto& [row, power] : thread.invalid_powers) {
        const display::Tracker tracker = services.raster->begin(0, 0, batch.rows[row]);
        services.raster->lpe().contribute(power, display::Technique::light_tracing, tracker);  // counted and logged
    }
}

}  // namespace raylex::transport
