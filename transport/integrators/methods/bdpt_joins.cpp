// Where bidirectional path tracing's subpaths meet: lights found, light samples, joined vertices, the camera.
#include <cmath>

#include "transport/integrators/methods/bdpt_state.h"

namespace raylex::transport {

void Bdpt::Ends::add(std::uint32_t row, const Rgb& emitted, const LightSample& at, Real sampled, const Vec3& towards) {
    const Subpath& path = camera.path(row);
    if (path.depth < self.first_depth_) return;
    Real weight = 1;
    if (path.depth > 0) {  // what the camera sees directly is found in no other way
        const SceneView& scene = self.context_.scene;
        const EmissionDensity emission =
            self.can_emit_ ? scene.lights->emission_density(self.emitters_, *scene.geometry, at, towards)
                           : EmissionDensity();
        const double pdf = path.specular ? 1 : static_cast<double>(path.pdf);
        weight = StrategySums::weight(camera.sums(row).others_at_light(static_cast<double>(sampled) / pdf,
                                                                       static_cast<double>(emission.position),
                                                                       static_cast<double>(emission.direction)));
    }
    const Rgb unweighted = camera.throughput(row) * emitted;
    if (unweighted.is_black()) return;
    camera.record().arrive(row, camera.record().events().terminal(at.light), {0, path.depth + 2},
                           {unweighted * weight, emitted, unweighted, 1, !path.specular && sampled > 0});
}

void Bdpt::Ends::emits(std::size_t j) {
    const VertexBatch& v = camera.vertices();
    const SceneView& scene = self.context_.scene;
    const SurfacePoint& point = v.points[j];
    LightSample at;
    at.light = scene.geometry->shapes()[v.hits[j].shape].first_light + v.hits[j].primitive;
    at.target = point.position;
    at.target_normal = point.geometric_normal;
    at.uv = {v.hits[j].u, v.hits[j].v};
    const Rgb emitted = scene.lights->emitted(at.light, point, point.wo);
    if (emitted.is_black()) return;
    const Subpath& path = camera.path(v.rows[j]);
    const Real sampled = path.depth > 0 ? scene.lights->density(self.sampled_, *scene.geometry, path.from, at) : 0.0f;
    add(v.rows[j], emitted, at, sampled, point.wo);
}

void Bdpt::Ends::escapes(std::uint32_t row, const Ray& ray) {
    const LightTable& lights = *self.context_.scene.lights;
    if (lights.environments().empty()) return;
    const Subpath& path = camera.path(row);
    camera.sums(row).arrive(path.specular ? 1 : static_cast<double>(path.pdf), static_cast<double>(path.cosine));
    for (const std::uint32_t light : lights.environments()) {
        LightSample at;
        at.light = light;
        at.infinite = true;
        at.wi = ray.direction;
        add(row, lights.environment_radiance(light, path.from, ray.direction), at,
            lights.environment_density(self.sampled_, light, path.from, ray.direction), -ray.direction);
    }
}

void Bdpt::Ends::volume_emits(std::uint32_t row, const Rgb& emitted) {
    const Subpath& path = camera.path(row);
    if (path.depth < self.first_depth_) return;
    const Rgb value = camera.throughput(row) * emitted;
    camera.record().arrive(row, camera.record().events().emission(), {0, path.depth + 2}, {value, emitted, value});
}

StrategySums::Wide Bdpt::others_beside_light_sample(const BdptThread& thread, std::size_t j, const LightSample& sample,
                                                    const JoinedScattering& f) const {
    const VertexBatch& v = thread.camera.vertices();
    const SurfacePoint& point = v.points[j];
    const LightTable& lights = *context_.scene.lights;
    const Light& light = lights.lights()[sample.light];
    const double pdf = static_cast<double>(sample.pdf);
    // The camera subpath meets the light by itself; light subpaths begin there.
    const StrategySums::Wide met = light.is_delta() ? 0 : StrategySums::squared(static_cast<double>(f.f.pdf) / pdf);
    if (!can_emit_) return met;
    const EmissionDensity emission = lights.emission_density(emitters_, *context_.scene.geometry, sample, -sample.wi);
    const double near = sample.infinite ? 1 : 1 / static_cast<double>(length_squared(sample.target - point.position));
    const double light_cosine = light.is_area() ? std::abs(dot(sample.target_normal, sample.wi)) : 1;
    const double to_light = light.is_area() ? light_cosine * near : 1;
    const double begun = to_light > 0 ? static_cast<double>(emission.position) / (pdf * to_light) : 0;
    const double cosine = static_cast<double>(point.cosine(sample.wi));
    return met + StrategySums::squared(begun) *
                     thread.camera.sums(v.rows[j]).others(static_cast<double>(emission.direction) * cosine * near,
                                                          static_cast<double>(f.pdf_reverse));
}

void Bdpt::sample_light(BdptThread& thread, std::size_t j, const display::Foresight::Ahead& ahead) const {
    if ((ahead.terminals & sampled_terminals_) == 0) return thread.counters.count(Pruned::light_samples);
    const CameraSubpaths& camera = thread.camera;
    LightSample sample;
    if (!draw_light_sample(context_.scene, sampled_, camera, j, sample)) return;
    const JoinedScattering scattering = evaluate_scattering<TransportMode::radiance>(
        camera.vertices().bsdfs[j], camera.vertices().points[j], sample.wi);
    if (scattering.f.value.is_black()) return;
    thread.joins.add_light_sample(camera, j, sample, scattering.f,
                                  StrategySums::weight(others_beside_light_sample(thread, j, sample, scattering)));
}

void Bdpt::join_vertices(BdptThread& thread, std::size_t j) const {
    const VertexBatch& v = thread.camera.vertices();
    const std::uint32_t row = v.rows[j];
    const Subpath& path = thread.camera.path(row);
    const StrategySums& sums = thread.camera.sums(row);
    const SurfacePoint& point = v.points[j];
    const DepthLimit& limit = thread.camera.depth_limit();
    const VertexDepth length = thread.camera.vertex_depth(j);
    const bool bodies = limit.has_bodies();
    for (std::uint32_t i = thread.last_vertex[row]; i != LightVertex::none; i = thread.light_vertices[i].previous) {
        const LightVertex& y = thread.light_vertices[i];
        if (!limit.allows(length.least + y.length.least)) continue;
        if (!thread.light.worth_joining(thread.camera, j, y.end, y.point.material)) {
            thread.counters.count(Pruned::joins);
            continue;
        }
        const Vec3 between = y.point.position - point.position;
        const Real d2 = length_squared(between);
        if (!(d2 > 0)) continue;
        const Vec3 direction = between / std::sqrt(d2);
        if (bodies && !limit.allows(length.before + limit.event(length, point, direction) + y.length.before +
                                    limit.event(y.length, y.point, -direction)))
            continue;
        const JoinedScattering x = evaluate_scattering<TransportMode::radiance>(v.bsdfs[j], point, direction);
        if (x.f.value.is_black()) continue;
        const JoinedScattering z = evaluate_scattering<TransportMode::importance>(y.bsdf, y.point, -direction);
        if (z.f.value.is_black()) continue;
        const double near = 1 / static_cast<double>(d2);
        const double at_camera = static_cast<double>(point.cosine(direction)) * near,
                     at_light = static_cast<double>(y.point.cosine(direction)) * near;
        VertexJoin join;
        join.j = j;
        join.f = &x.f;
        join.weight = StrategySums::weight(
            sums.others(static_cast<double>(z.f.pdf) * at_camera, static_cast<double>(x.pdf_reverse)) +
            y.sums.others(static_cast<double>(x.f.pdf) * at_light, static_cast<double>(z.pdf_reverse)));
        join.unweighted = path.beta * x.f.value * z.f.value * y.power * (1 / d2);
        if (path.one_wavelength || y.one_wavelength) join.unweighted *= thread.light.wavelength_weight(row);
        join.end = y.end;
        join.end.lobes = z.f.lobes;
        join.light_vertices = y.depth + 2;
        join.shadow_ray =
            segment_to(offset_ray_origin(point.position, point.geometric_normal, v.sources[j].offset.here, direction),
                       y.point.position, y.point.geometric_normal, y.offset);
        thread.joins.add_join(thread.camera, join);
    }
}

void Bdpt::connect_to_camera(const CameraBatch& batch, BdptThread& thread, ThreadServices& services) const {
    for (const LightVertex& y : thread.light_vertices) {
        if (!y.ahead.seen) {
            thread.counters.count(Pruned::joins);
            continue;
        }
        const Rgb power = y.one_wavelength ? y.power * thread.light.wavelength_weight(y.row) : y.power;
        const Vec2 lens = context_.camera->has_lens()
                              ? batch.samplers[y.row].get_2d(
                                    subpath_dimensions<TransportMode::importance>.of(y.depth, camera_lens_dimension))
                              : Vec2{0, 0};
        thread.splats.add(view_, thread.light.depth_limit(),
                          {y.row, y.depth, y.length, &y.point, &y.bsdf, y.offset, y.holdout, power, y.end, &y.sums,
                           batch.rays[y.row].time, connection_key(context_.scene, batch.samplers[y.row], y.depth)},
                          lens);
    }
    if (!context_.beauty && !context_.scene.geometry->has_alpha())
        thread.splats.drop_dead(thread.camera.record(), thread.counters);
    thread.splats.splat(context_.scene, *context_.events, batch.rows, *services.raster, thread.counters);
    for (const auto& [row, power] : thread.invalid_powers) reject_power(services, batch.rows[row], power);
}

}  // namespace raylex::transport
