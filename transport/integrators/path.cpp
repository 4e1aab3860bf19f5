#include "transport/integrators/path.h"

#include <algorithm>

#include "transport/integrators/path_state.h"
#include "transport/math/sampling.h"

namespace raylex::transport {
namespace {

// Sampler dimensions of vertex k start at first_free_dimension + k * stride.
enum VertexDimension : std::uint32_t {
    choice_dimension,
    light_dimension,
    scatter_dimension,
    lobe_dimension,
    roulette_dimension,
    key_dimension,
    stride
};
constexpr std::uint32_t cutout_dimensions = 1u << 24;  // one per ray, far above every vertex's

std::uint32_t dimension(const PathState& path, VertexDimension which) {
    return first_free_dimension + path.depth * stride + which;
}

}  // namespace

Status PathIntegrator::prepare(const IntegratorContext& context) {
    context_ = context;
    can_sample_lights_ = context.scene.lights->can_sample(choice());
    reports_surfaces_ = context.events->wants_user();
    return success();
}

std::unique_ptr<IntegratorThread> PathIntegrator::make_thread_state() const {
    // Longer paths than 1024 share the histogram's last slot.
    return std::make_unique<PathThread>(static_cast<std::size_t>(context_.batch_capacity),
                                        std::min<std::size_t>(parameters_.max_depth, 1024) + 1);
}

void PathIntegrator::integrate(const CameraBatch& batch, IntegratorThread& state, ThreadServices& services) const {
    auto& thread = static_cast<PathThread&>(state);
    start(batch, thread, services);
    while (thread.next_count > 0) {
        trace(thread, services);
        resolve(thread, services);
        VertexBatch& v = thread.vertices;
        if (v.count == 0) continue;
        context_.scene.materials->shade(*context_.scene.textures, {v.points.data(), v.count},
                                        {v.bsdfs.data(), v.count});
        write_aovs(thread, services);
        if (reports_surfaces_) report_surfaces(thread, services);
        sample_lights(thread, services);
        add_lights(thread, services);
        scatter(thread, services);
    }
}

void PathIntegrator::start(const CameraBatch& batch, PathThread& thread, ThreadServices& services) const {
    const std::size_t count = batch.rays.size();
    thread.next_count = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const auto row = static_cast<std::uint32_t>(i);
        thread.paths[i] = PathState();
        thread.samplers[i] = batch.samplers[i];
        thread.trackers[i] = services.lpe.begin(static_cast<int>(i));
        thread.push_next(row, batch.rays[i]);
    }
    thread.counters.camera_rays += count;
}

void PathIntegrator::trace(PathThread& thread, ThreadServices& services) const {
    VertexBatch& v = thread.vertices;
    const std::size_t count = thread.next_count;
    thread.next_count = 0;
    context_.scene.geometry->intersect({thread.next_rays.data(), count}, {v.hits.data(), count});
    v.count = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t row = thread.next_rows[i];
        if (!v.hits[i].valid()) {
            escape(thread, services, row, thread.next_rays[i]);
            continue;
        }
        v.rows[v.count] = row;
        v.rays[v.count] = thread.next_rays[i];
        v.hits[v.count] = v.hits[i];
        ++v.count;
    }
    context_.scene.geometry->surfaces({v.rays.data(), v.count}, {v.hits.data(), v.count}, {v.points.data(), v.count},
                                      {v.sources.data(), v.count});
}

float PathIntegrator::scattering_weight(const PathState& path, float light_pdf) const {
    if (!sampled_too(path, light_pdf)) return 1;
    if (parameters_.strategy == PathStrategy::light) return 0;
    return power_heuristic(path.scatter_pdf, light_pdf);
}

void PathIntegrator::deliver(PathThread& thread, ThreadServices& services, std::uint32_t row, const Rgb& emitted,
                             float light_pdf, std::uint32_t light) const {
    const PathState& path = thread.paths[row];
    const float weight = scattering_weight(path, light_pdf);
    if (!(weight > 0)) return;
    display::Tracker tracker = thread.trackers[row];
    services.lpe.move(tracker, context_.events->terminal(light));
    const Rgb value = path.beta * emitted * weight;
    if (services.lpe.wants_emitter_samples())
        services.lpe.contribute(value, display::Technique::scattering, tracker,
                                {emitted, path.beta * emitted, 1, sampled_too(path, light_pdf)});
    else
        services.lpe.contribute(value, display::Technique::scattering, tracker);
}

void PathIntegrator::escape(PathThread& thread, ThreadServices& services, std::uint32_t row, const Ray& ray) const {
    const LightTable& lights = *context_.scene.lights;
    const PathState& path = thread.paths[row];
    for (const std::uint32_t light : lights.environments()) {
        const float light_pdf = path.certain ? 0.0f : lights.environment_density(choice(), light, ray.direction);
        deliver(thread, services, row, lights.environment_radiance(light, ray.direction), light_pdf, light);
    }
    thread.finish(row);
}

void PathIntegrator::emit(PathThread& thread, ThreadServices& services, std::size_t j) const {
    const VertexBatch& v = thread.vertices;
    const ShapeGeometry& shape = context_.scene.geometry->shapes()[v.hits[j].shape];
    const std::uint32_t light = shape.first_light + v.hits[j].primitive;
    const LightTable& lights = *context_.scene.lights;
    const Rgb emitted = lights.emitted(light, v.points[j].geometric_normal, v.points[j].wo);
    if (emitted.is_black()) return;
    const PathState& path = thread.paths[v.rows[j]];
    const float light_pdf =
        path.certain ? 0.0f
                     : lights.density(choice(), *context_.scene.geometry, light, path.from, v.points[j], v.hits[j]);
    deliver(thread, services, v.rows[j], emitted, light_pdf, light);
}

bool PathIntegrator::passes(PathThread& thread, ThreadServices& services, std::size_t j) const {
    VertexBatch& v = thread.vertices;
    const ShapeGeometry& shape = context_.scene.geometry->shapes()[v.hits[j].shape];
    const std::uint32_t row = v.rows[j];
    PathState& path = thread.paths[row];
    const SurfacePoint& point = v.points[j];
    // Closest hit first, then one counter-based choice: in expectation what alpha blending gives, and what pbrt does.
    const float alpha = context_.scene.textures->real(shape.alpha, {point.u, point.v, point.position});
    if (thread.samplers[row].get_random(cutout_dimensions + path.segment) < alpha) return false;
    services.lpe.move(thread.trackers[row], context_.events->straight(v.sources[j].label));
    path.travelled += v.hits[j].t;
    // This ray went through, so its own opacity at the cutout is 0: over many rays the mean is the cutout's alpha.
    if (path.depth == 0) services.display.add_sample(static_cast<int>(row), {path.travelled, RgbD(0.0), false});
    Ray ray;
    ray.direction = v.rays[j].direction;
    ray.origin = leave_surface(point.position, point.geometric_normal, v.sources[j].offset, ray.direction);
    ++path.segment;
    thread.push_next(row, ray);
    ++(path.depth == 0 ? thread.counters.camera_rays : thread.counters.scattering_rays);
    return true;
}

void PathIntegrator::record_first_hit(PathThread& thread, ThreadServices& services, std::size_t j) const {
    const VertexBatch& v = thread.vertices;
    const int row = static_cast<int>(v.rows[j]);
    services.display.write_distance(row, thread.paths[v.rows[j]].travelled + v.hits[j].t);
    const bool holdout =
        context_.scene.geometry->has_holdouts() && context_.scene.geometry->is_holdout(v.hits[j]);
    services.display.write_opacity(row, Rgb(holdout ? 0.0f : 1.0f));
    services.display.write_surface(row, context_.scene.geometry->surface_number(v.hits[j]));
    if (holdout) services.lpe.hold_out(thread.trackers[v.rows[j]]);
}

bool PathIntegrator::worth_shading(const PathState& path, const display::Tracker& tracker,
                                   const display::LpeServices& lpe) const {
    if (path.depth == 0 && context_.aovs->inputs() != 0) return true;
    if (reports_surfaces_ && lpe.channels_follow(tracker)) return true;
    return path.depth < parameters_.max_depth && lpe.live(tracker);
}

void PathIntegrator::resolve(PathThread& thread, ThreadServices& services) const {
    VertexBatch& v = thread.vertices;
    const bool cutouts = context_.scene.geometry->has_alpha();
    const bool hidden_environments =
        services.lpe.wants_emitter_samples() && !context_.scene.lights->environments().empty();
    const std::span<const ShapeGeometry> shapes = context_.scene.geometry->shapes();
    std::size_t kept = 0;
    for (std::size_t j = 0; j < v.count; ++j) {
        const ShapeGeometry& shape = shapes[v.hits[j].shape];
        const std::uint32_t row = v.rows[j];
        PathState& path = thread.paths[row];
        const bool emits = shape.first_light != Hit::none;
        if (cutouts && shape.alpha >= 0) {
            if (emits && shape.interface) emit(thread, services, j);  // a light without a surface still shines
            if (passes(thread, services, j)) continue;
        }
        if (path.depth == 0) record_first_hit(thread, services, j);
        if (emits) emit(thread, services, j);
        if (hidden_environments && !path.certain) report_hidden_environments(thread, services, j);
        if (!worth_shading(path, thread.trackers[row], services.lpe)) {
            thread.finish(row);
            continue;
        }
        v.points[j].random_key = thread.samplers[row].key(dimension(path, key_dimension));
        v.keep(j, kept++);
    }
    v.count = kept;
}

void PathIntegrator::move(display::Tracker& tracker, display::LpeServices& lpe, std::int32_t label,
                          const LobeList& lobes) const {
    if (!context_.events->any()) return;
    std::array<display::LobePart, max_lobes> parts;
    for (std::size_t i = 0; i < static_cast<std::size_t>(lobes.count); ++i)
        parts[i] = {context_.events->scatter(label, lobes.entry[i].lobe), lobes.entry[i].value};
    lpe.move(tracker, {parts.data(), static_cast<std::size_t>(lobes.count)});
}

float PathIntegrator::emitter_opacity(const LightSample& sample, const Vec3& from) const {
    const Light& light = context_.scene.lights->lights()[sample.light];
    if (!light.is_area() || light.hidden) return 1;
    const ShapeGeometry& shape = context_.scene.geometry->shapes()[light.shape];
    if (shape.alpha < 0 || shape.interface) return 1;
    Ray ray[1];
    ray[0].origin = from;
    ray[0].direction = sample.target - from;
    const Hit hit[1] = {{1, sample.uv.x, sample.uv.y, light.shape, light.primitive, Hit::none}};
    SurfacePoint point[1];
    SurfaceSource source[1];
    context_.scene.geometry->surfaces(ray, hit, point, source);
    return std::clamp(context_.scene.textures->real(shape.alpha, {point[0].u, point[0].v, point[0].position}), 0.0f,
                      1.0f);
}

void PathIntegrator::sample_lights(PathThread& thread, ThreadServices& services) const {
    thread.pending_count = 0;
    if (!can_sample_lights_) return;
    const VertexBatch& v = thread.vertices;
    const LightTable& lights = *context_.scene.lights;
    const bool cutouts = context_.scene.geometry->has_alpha();
    const bool own_choice = lights.needs_choice_number(choice());
    const bool with_emitters = services.lpe.wants_emitter_samples();
    for (std::size_t j = 0; j < v.count; ++j) {
        const std::uint32_t row = v.rows[j];
        const PathState& path = thread.paths[row];
        if (!v.bsdfs[j].has_density() || path.depth >= parameters_.max_depth) continue;
        const PixelSampler& sampler = thread.samplers[row];
        const float u_choice = own_choice ? sampler.get_1d(dimension(path, choice_dimension)) : 0.0f;
        LightSample sample;
        if (!lights.sample(choice(), *context_.scene.geometry, v.points[j].position, u_choice,
                           sampler.get_2d(dimension(path, light_dimension)), sample))
            continue;
        if (parameters_.strategy == PathStrategy::scattering && !sample.delta) continue;
        if (cutouts) sample.radiance *= emitter_opacity(sample, v.points[j].position);
        const BsdfEvaluation f = v.bsdfs[j].evaluate(v.points[j].wo, sample.wi);
        if (f.value.is_black()) continue;
        float weight = 1;
        if (!sample.delta && parameters_.strategy == PathStrategy::mis) weight = power_heuristic(sample.pdf, f.pdf);
        const Rgb value = path.beta * f.value * sample.radiance * (weight / sample.pdf);
        display::EmitterSample emitter;
        if (with_emitters)
            emitter = {lights.emitted(sample, v.points[j].position),
                       path.beta * f.value * sample.radiance * (1 / sample.pdf), 1, false};
        if (value.is_black() && emitter.unweighted.is_black()) continue;
        if (!cutouts && !services.lpe.takes_all(thread.trackers[row])) {
            // Only channels matter: a light whose group no channel can still accept is not worth a ray (Law 4), nor is
            // one whose shadows nobody sees.
            const lpe::EventClass terminal = context_.events->terminal(sample.light);
            display::Tracker ahead = thread.trackers[row];
            move(ahead, services.lpe, v.sources[j].label, f.lobes);
            if (!services.lpe.live_after(ahead, terminal)) continue;
            services.lpe.move(ahead, terminal);
            if (with_emitters && !services.lpe.needs_visibility(ahead)) {
                services.lpe.contribute(value, display::Technique::light_sampling, ahead, emitter);
                continue;
            }
        }
        if (with_emitters) thread.emitters[thread.pending_count] = emitter;
        PendingLight& pending = thread.pending[thread.pending_count];
        pending = {row, sample.light, v.sources[j].label, value, f.lobes};
        thread.shadow_rays[thread.pending_count++] =
            shadow_ray(v.points[j].position, v.points[j].geometric_normal, v.sources[j].offset, sample);
    }
    thread.counters.shadow_rays += thread.pending_count;
}

float PathIntegrator::straight_transmittance(Ray ray, display::Tracker& tracker, ThreadServices& services,
                                             IntegratorCounters& counters) const {
    const EmbreeScene& geometry = *context_.scene.geometry;
    const bool finite_end = ray.t_max < infinity;
    const Vec3 end = ray.origin + ray.direction;
    float transmittance = 1;
    for (;;) {
        Hit hit;
        geometry.intersect_alpha(ray, hit);
        ++counters.shadow_rays;
        if (!hit.valid()) return transmittance;
        const Hit hits[1] = {hit};
        const Ray rays[1] = {ray};
        SurfacePoint point[1];
        SurfaceSource source[1];
        geometry.surfaces(rays, hits, point, source);
        const ShapeGeometry& shape = geometry.shapes()[hit.shape];
        transmittance *=
            1 - std::clamp(context_.scene.textures->real(shape.alpha, {point[0].u, point[0].v, point[0].position}),
                           0.0f, 1.0f);
        if (!(transmittance > 0)) return 0;
        services.lpe.move(tracker, context_.events->straight(source[0].label));
        ray.origin = leave_surface(point[0].position, point[0].geometric_normal, source[0].offset, ray.direction);
        if (finite_end) {
            const Vec3 rest = end - ray.origin;
            if (!(dot(rest, ray.direction) > 0)) return transmittance;
            ray.direction = rest;
        }
    }
}

void PathIntegrator::add_lights(PathThread& thread, ThreadServices& services) const {
    if (thread.pending_count == 0) return;
    const EmbreeScene& geometry = *context_.scene.geometry;
    geometry.occluded({thread.shadow_rays.data(), thread.pending_count}, {thread.blocked.data(), thread.pending_count});
    const bool with_emitters = services.lpe.wants_emitter_samples();
    for (std::size_t i = 0; i < thread.pending_count; ++i) {
        if (thread.blocked[i] && !with_emitters) continue;
        const PendingLight& pending = thread.pending[i];
        display::Tracker tracker = thread.trackers[pending.row];
        move(tracker, services.lpe, pending.label, pending.lobes);
        Rgb value = pending.value;
        float transmittance = thread.blocked[i] ? 0.0f : 1.0f;
        if (!thread.blocked[i] && geometry.has_alpha()) {
            transmittance = straight_transmittance(thread.shadow_rays[i], tracker, services, thread.counters);
            if (!(transmittance > 0) && !with_emitters) continue;
            value *= transmittance;
        }
        services.lpe.move(tracker, context_.events->terminal(pending.light));
        if (!with_emitters) {
            services.lpe.contribute(value, display::Technique::light_sampling, tracker);
            continue;
        }
        display::EmitterSample emitter = thread.emitters[i];
        emitter.visibility = transmittance;
        services.lpe.contribute(transmittance > 0 ? value : Rgb(), display::Technique::light_sampling, tracker, emitter);
    }
}

void PathIntegrator::scatter(PathThread& thread, ThreadServices& services) const {
    const VertexBatch& v = thread.vertices;
    const bool lights_can_be_hit = context_.scene.lights->any_to_hit();
    for (std::size_t j = 0; j < v.count; ++j) {
        const std::uint32_t row = v.rows[j];
        PathState& path = thread.paths[row];
        const PixelSampler& sampler = thread.samplers[row];
        if (path.depth >= parameters_.max_depth) {  // here for its AOVs only
            thread.finish(row);
            continue;
        }
        const Bsdf& bsdf = v.bsdfs[j];
        const SurfacePoint& point = v.points[j];
        const float u_lobe =
            bsdf.kind() == Bsdf::Kind::lambert ? 0.0f : sampler.get_1d(dimension(path, lobe_dimension));
        const BsdfSample s = bsdf.sample(point.wo, u_lobe, sampler.get_2d(dimension(path, scatter_dimension)));
        if (!(s.pdf > 0) || s.weight.is_black()) {
            thread.finish(row);
            continue;
        }
        const std::uint32_t roulette = dimension(path, roulette_dimension);
        path.beta *= s.weight;
        ++path.depth;
        ++path.segment;
        if (s.transmitted) path.eta_scale *= s.eta * s.eta;
        path.certain = s.delta;
        path.scatter_pdf = s.pdf_is_proportional && !s.delta ? bsdf.pdf(point.wo, s.wi) : s.pdf;
        path.from = point.position;
        move(thread.trackers[row], services.lpe, v.sources[j].label, s.lobes);
        if (!is_finite(path.beta)) {
            services.lpe.contribute(path.beta, display::Technique::scattering,
                                    thread.trackers[row]);  // counted and logged
            thread.finish(row);
            continue;
        }
        if (parameters_.roulette && path.depth > 1) {
            const float keep = path.beta.max() * path.eta_scale;
            if (keep < 1) {
                if (sampler.get_random(roulette) >= keep) {
                    thread.finish(row);
                    continue;
                }
                path.beta *= 1 / keep;
            }
        }
        const bool nothing_to_find = path.depth >= parameters_.max_depth && !lights_can_be_hit;
        if (nothing_to_find || !services.lpe.live(thread.trackers[row])) {
            thread.finish(row);
            continue;
        }
        Ray ray;
        ray.direction = s.wi;
        ray.origin = leave_surface(point.position, point.geometric_normal, v.sources[j].offset, s.wi);
        thread.push_next(row, ray);
        ++thread.counters.scattering_rays;
    }
}

}  // namespace raylex::transport
