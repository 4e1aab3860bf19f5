#include "transport/integrators/path.h"

#include <algorithm>

#include "transport/integrators/first_hits.h"
#include "transport/integrators/path_state.h"
#include "transport/math/sampling.h"
#include "transport/paths/walk.h"

namespace raylex::transport {
Status PathIntegrator::prepare(const IntegratorContext& context) {
    context_ = context;
    can_sample_lights_ = context.scene.lights->can_sample(choice());
    reports_surfaces_ = context.events->wants_user();
    in_media_ = context.scene.media->any();
    emitters_can_be_hit_ = context.scene.lights->any_to_hit() || context.scene.media->any_emits();
    return success();
}

std::unique_ptr<IntegratorThread> PathIntegrator::make_thread_state() const {
    // Longer paths than 1024 share the histogram's last slot.
    return std::make_unique<PathThread>(static_cast<std::size_t>(context_.batch_capacity),
                                        std::min<std::size_t>(parameters_.max_depth, 1024) + 1, in_media_);
}

void PathIntegrator::integrate(const CameraBatch& batch, IntegratorThread& state, ThreadServices& services) const {
    auto& thread = static_cast<PathThread&>(state);
    start(batch, thread, services);
    while (thread.queue.count > 0 && !services.leaving()) {
        trace_rays(thread, services);
        resolve(thread, services);
        VertexBatch& v = thread.vertices;
        if (v.count == 0 && (!in_media_ || thread.collisions.count == 0)) continue;
        context_.scene.materials->shade(*context_.scene.textures, {v.points.data(), v.count},
                                        {v.bsdfs.data(), v.count}, &services.display);
        write_first_hits(context_, v, {thread.first_entries.data(), thread.first_count}, thread.first_hits,
                         services.display);
        if (reports_surfaces_) report_surfaces(thread, services);
        sample_lights(thread, services);
        if (in_media_) sample_lights_in_media(thread, services);
        add_lights(thread, services);
        if (in_media_) scatter_in_media(thread, services);
        scatter(thread, services);
    }
}

void PathIntegrator::start(const CameraBatch& batch, PathThread& thread, ThreadServices& services) const {
    const std::size_t count = batch.rays.size();
    thread.queue.count = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const auto row = static_cast<std::uint32_t>(i);
        thread.paths[i] = PathState();
        thread.samplers[i] = batch.samplers[i];
        thread.trackers[i] = services.lpe.begin(static_cast<int>(i));
        thread.queue.push(row, batch.rays[i]);
    }
    if (in_media_) std::fill_n(thread.media.begin(), count, context_.scene.media->camera());
    thread.counters.camera_rays += count;
}

void PathIntegrator::trace_rays(PathThread& thread, ThreadServices& services) const {
    const EmbreeScene& geometry = *context_.scene.geometry;
    const auto hits_surface = [&](std::uint32_t row, const Ray& ray, const Hit& hit) {
        if (!hit.valid()) escape(thread, services, row, ray);
        return hit.valid();
    };
    if (!in_media_) return trace(geometry, thread.queue, thread.vertices, hits_surface);
    thread.collisions.count = 0;
    trace(geometry, thread.queue, thread.vertices, [&](std::uint32_t row, const Ray& ray, const Hit& hit) {
        const std::int32_t medium = thread.media[row];
        return (medium < 0 || cross_medium(thread, services, row, ray, medium, hit.t)) && hits_surface(row, ray, hit);
    });
}

float PathIntegrator::scattering_weight(const PathState& path, float light_pdf) const {
    if (!sampled_too(path, light_pdf)) return 1;
    if (parameters_.strategy == PathStrategy::light) return 0;
    return power_heuristic(path.scatter_pdf, light_pdf);
}

void PathIntegrator::add_emission(PathThread& thread, ThreadServices& services, std::uint32_t row, const Rgb& emitted,
                                  float light_pdf, std::uint32_t light) const {
    const PathState& path = thread.paths[row];
    const float weight = scattering_weight(path, light_pdf);
    if (!(weight > 0) || path.depth < parameters_.first_depth) return;
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
        const float light_pdf =
            path.specular_bounce ? 0.0f : lights.environment_density(choice(), light, ray.direction);
        add_emission(thread, services, row, lights.environment_radiance(light, ray.direction), light_pdf, light);
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
        path.specular_bounce
            ? 0.0f
            : lights.density(choice(), *context_.scene.geometry, light, path.from, v.points[j], v.hits[j]);
    add_emission(thread, services, v.rows[j], emitted, light_pdf, light);
}

bool PathIntegrator::passes_cutout(PathThread& thread, ThreadServices& services, std::size_t j) const {
    VertexBatch& v = thread.vertices;
    const ShapeGeometry& shape = context_.scene.geometry->shapes()[v.hits[j].shape];
    const std::uint32_t row = v.rows[j];
    PathState& path = thread.paths[row];
    const SurfacePoint& point = v.points[j];
    if (!passes_alpha_test(context_.scene, v, j, thread.samplers[row].get_random(cutout_dimensions + path.segment)))
        return false;
    services.lpe.move(thread.trackers[row], context_.events->straight(v.sources[j].label));
    path.travelled += v.hits[j].t;
    // This ray went through, so its own opacity at the cutout is 0: over many rays the mean is the cutout's alpha.
    if (path.depth == 0) services.display.add_sample(static_cast<int>(row), {path.travelled, RgbD(0.0), false});
    const Vec3& direction = v.rays[j].direction;
    // What a cutout takes away of a surface is no border between media either.
    if (in_media_ && shape.interface)
        thread.media[row] = shape.medium_towards(point.geometric_normal, direction, thread.media[row]);
    ++path.segment;
    thread.queue.push(row, ray_from(v, j, direction));
    ++(path.depth == 0 ? thread.counters.camera_rays : thread.counters.scattering_rays);
    return true;
}

bool PathIntegrator::worth_shading(const PathState& path, const display::Tracker& tracker,
                                   const display::LpeServices& lpe) const {
    if (path.depth == 0 && (context_.aovs->inputs() != 0 || context_.pattern_channels)) return true;
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
    thread.first_count = 0;
    for (std::size_t j = 0; j < v.count; ++j) {
        const ShapeGeometry& shape = shapes[v.hits[j].shape];
        const std::uint32_t row = v.rows[j];
        PathState& path = thread.paths[row];
        const bool emits = shape.first_light != Hit::none;
        if (cutouts && shape.alpha >= 0) {
            if (emits && shape.interface) emit(thread, services, j);  // a light without a surface still shines
            if (passes_cutout(thread, services, j)) continue;
        }
        if (path.depth == 0 && record_first_hit(*context_.scene.geometry, static_cast<int>(row),
                                                path.travelled + v.hits[j].t, v.hits[j], services.display))
            services.lpe.hold_out(thread.trackers[row]);
        if (emits) emit(thread, services, j);
        if (hidden_environments && !path.specular_bounce) report_hidden_environments(thread, services, j);
        if (!worth_shading(path, thread.trackers[row], services.lpe)) {
            thread.finish(row);
            continue;
        }
        v.points[j].random_key = thread.samplers[row].key(dimension(path, key_dimension));
        v.points[j].row = path.depth == 0 ? static_cast<std::int32_t>(row) : -1;
        if (path.depth == 0) thread.first_entries[thread.first_count++] = static_cast<std::uint32_t>(kept);
        v.keep(j, kept++);
    }
    v.count = kept;
}

bool PathIntegrator::goes_on(PathThread& thread, ThreadServices& services, std::uint32_t row,
                             std::uint32_t roulette) const {
    PathState& path = thread.paths[row];
    if (!is_finite(path.beta)) {
        services.lpe.contribute(path.beta, display::Technique::scattering, thread.trackers[row]);  // counted and logged
        thread.finish(row);
        return false;
    }
    if (parameters_.roulette && path.depth > 1) {
        const float keep = path.beta.max() * path.eta_scale;
        if (keep < 1) {
            if (thread.samplers[row].get_random(roulette) >= keep) {
                thread.finish(row);
                return false;
            }
            path.beta *= 1 / keep;
        }
    }
    const bool nothing_to_find = path.depth >= parameters_.max_depth && !emitters_can_be_hit_;
    if (nothing_to_find || !services.lpe.live(thread.trackers[row])) {
        thread.finish(row);
        return false;
    }
    return true;
}

void PathIntegrator::scatter(PathThread& thread, ThreadServices& services) const {
    const VertexBatch& v = thread.vertices;
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
        path.specular_bounce = s.delta;
        path.scatter_pdf = s.pdf_is_proportional && !s.delta ? bsdf.pdf(point.wo, s.wi) : s.pdf;
        path.from = point.position;
        move_by_lobes(thread.trackers[row], services.lpe, *context_.events, v.sources[j].label, s.lobes);
        if (!goes_on(thread, services, row, roulette)) continue;
        if (in_media_)
            thread.media[row] = context_.scene.geometry->shapes()[v.hits[j].shape].medium_towards(
                point.geometric_normal, s.wi, thread.media[row]);
        thread.queue.push(row, ray_from(v, j, s.wi));
        ++thread.counters.scattering_rays;
    }
}

}  // namespace raylex::transport
