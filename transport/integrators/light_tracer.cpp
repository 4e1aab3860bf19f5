#include "transport/integrators/light_tracer.h"

#include <algorithm>
#include <cmath>

#include "transport/integrators/light_tracer_state.h"
#include "transport/integrators/straight.h"
#include "transport/math/sampling.h"

namespace raylex::transport {

void LightTracer::integrate(const CameraBatch& batch, IntegratorThread& state, ThreadServices& services) const {
    auto& thread = static_cast<LightThread&>(state);
    camera_->integrate(batch, *thread.camera, services);
    thread.counters.add(thread.camera->counters);
    thread.camera->counters = IntegratorCounters();
    thread.camera->counters.path_lengths.assign(1, 0);
    if (!can_emit_ || services.left) return;
    emit(batch, thread);
    // Splats that were handed on cannot be taken back, and a batch that is left with such leaves no checkpoint. So a batch
    // is finished unless its paths go on for long: this many scatterings take milliseconds.
    constexpr int soon = 64;
    for (int scatterings = 0; thread.next_count > 0; ++scatterings) {
        if (scatterings >= soon && services.leaving()) break;
        trace(batch, thread);
        if (thread.count == 0) continue;
        context_.scene.materials->shade(*context_.scene.textures, {thread.points.data(), thread.count},
                                        {thread.bsdfs.data(), thread.count}, &services.display);
        connect(batch, thread, services);
        add_splats(batch, thread, services);
        scatter(batch, thread, services);
    }
}

void LightTracer::emit(const CameraBatch& batch, LightThread& thread) const {
    thread.next_count = 0;
    const LightTable& lights = *context_.scene.lights;
    const bool own_choice = lights.needs_choice_number(LightChoice::light_sampling);
    for (std::size_t i = 0; i < batch.rays.size(); ++i) {
        const auto row = static_cast<std::uint32_t>(i);
        const PixelSampler& sampler = batch.samplers[i];
        LightPath& path = thread.paths[row];
        path = LightPath();
        thread.words[row].clear();
        EmissionSample s;
        if (!lights.sample_emission(*context_.scene.geometry,
                                    own_choice ? sampler.get_1d(light_dimensions + emitter_dimension) : 0.0f,
                                    sampler.get_2d(light_dimensions + origin_dimension),
                                    sampler.get_2d(light_dimensions + direction_dimension), s)) {
            thread.finish(row);
            continue;
        }
        if (!s.from.infinite) s.power *= emitter_opacity(context_.scene, s.from, s.from.target + s.direction);
        path.power = s.power;
        path.start_power = s.power.max();
        path.light = s.from.light;
        if (s.power.is_black()) {
            thread.finish(row);
            continue;
        }
        Ray ray;
        ray.origin = s.origin;
        ray.direction = s.direction;
        thread.push_next(row, ray);
    }
    thread.counters.scattering_rays += thread.next_count;
}

void LightTracer::trace(const CameraBatch& batch, LightThread& thread) const {
    const std::size_t count = thread.next_count;
    thread.next_count = 0;
    thread.count = 0;
    const EmbreeScene& geometry = *context_.scene.geometry;
    geometry.intersect({thread.next_rays.data(), count}, {thread.hits.data(), count});
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t row = thread.next_rows[i];
        if (!thread.hits[i].valid()) {
            thread.finish(row);
            continue;
        }
        thread.rows[thread.count] = row;
        thread.rays[thread.count] = thread.next_rays[i];
        thread.hits[thread.count] = thread.hits[i];
        ++thread.count;
    }
    geometry.surfaces({thread.rays.data(), thread.count}, {thread.hits.data(), thread.count},
                      {thread.points.data(), thread.count}, {thread.sources.data(), thread.count});
    const bool cutouts = geometry.has_alpha();
    std::size_t kept = 0;
    for (std::size_t j = 0; j < thread.count; ++j) {
        if (cutouts && passes(batch, thread, j)) continue;
        const std::uint32_t row = thread.rows[j];
        thread.points[j].random_key = batch.samplers[row].key(dimension(thread.paths[row], light_key_dimension));
        thread.points[j].row = -1;
        thread.keep(j, kept++);
    }
    thread.count = kept;
}

bool LightTracer::passes(const CameraBatch& batch, LightThread& thread, std::size_t j) const {
    const ShapeGeometry& shape = context_.scene.geometry->shapes()[thread.hits[j].shape];
    if (shape.alpha < 0) return false;
    const std::uint32_t row = thread.rows[j];
    LightPath& path = thread.paths[row];
    const SurfacePoint& point = thread.points[j];
    const float alpha = context_.scene.textures->real(shape.alpha, {point.u, point.v, point.position});
    if (batch.samplers[row].get_random(light_cutout_dimensions + path.segment) < alpha) return false;
    if (reads_words_) thread.words[row].push_back({thread.sources[j].label, true, {}});
    Ray ray;
    ray.direction = thread.rays[j].direction;
    ray.origin = leave_surface(point.position, point.geometric_normal, thread.sources[j].offset, ray.direction);
    ++path.segment;
    thread.push_next(row, ray);
    ++thread.counters.scattering_rays;
    return true;
}

bool LightTracer::goes_on(const CameraBatch& batch, LightThread& thread, ThreadServices& services, std::uint32_t row,
                          std::uint32_t roulette) const {
    LightPath& path = thread.paths[row];
    if (!is_finite(path.power)) {  // counted and logged
        const display::Tracker tracker = services.raster->begin(0, 0, batch.rows[row]);
        services.raster->lpe().contribute(path.power, display::Technique::scattering, tracker);
        return false;
    }
    if (path.power.is_black()) return false;
    if (!parameters_.roulette || path.depth < 2) return true;
    const float keep = path.power.max() / path.start_power;
    if (!(keep < 1)) return true;
    if (batch.samplers[row].get_random(roulette) >= keep) return false;
    path.power *= 1 / keep;
    return true;
}

void LightTracer::scatter(const CameraBatch& batch, LightThread& thread, ThreadServices& services) const {
    for (std::size_t j = 0; j < thread.count; ++j) {
        const std::uint32_t row = thread.rows[j];
        LightPath& path = thread.paths[row];
        if (path.depth + 1 >= parameters_.max_depth) {  // the scattering towards the camera was its last
            ++path.depth;
            thread.finish(row);
            continue;
        }
        const PixelSampler& sampler = batch.samplers[row];
        const Bsdf& bsdf = thread.bsdfs[j];
        const SurfacePoint& point = thread.points[j];
        const Vec3& from_light = point.wo;
        const bool plain = bsdf.kind() == Bsdf::Kind::lambert;
        const float u_lobe = plain ? 0.0f : sampler.get_1d(dimension(path, light_lobe_dimension));
        const BsdfSample s = bsdf.sample(from_light, u_lobe, sampler.get_2d(dimension(path, light_scatter_dimension)));
        const float g_in = std::abs(dot(point.geometric_normal, from_light)),
                    g_out = std::abs(dot(point.geometric_normal, s.wi));
        if (!(s.pdf > 0) || !(g_in > 0)) {
            thread.finish(row);
            continue;
        }
        WordEvent event{thread.sources[j].label, false, s.lobes};
        if (plain || s.delta || s.pdf_is_proportional) {
            // The closure's weight is f(i, o) |s(o)| / density with the radiance's 1 / eta^2, which a light path's power has not.
            const Vec3& n = bsdf.frame().n;
            const float s_in = std::abs(dot(n, from_light)), s_out = std::abs(dot(n, s.wi));
            path.power *= s.weight * ((s_in / s_out) * (g_out / g_in) * (s.transmitted ? s.eta * s.eta : 1.0f));
        } else {
            const BsdfEvaluation f = bsdf.evaluate(s.wi, from_light);
            path.power *= f.value * (g_out / (g_in * s.pdf));
            event.lobes = f.lobes;
        }
        const std::uint32_t roulette = dimension(path, light_roulette_dimension);
        ++path.depth;
        ++path.segment;
        if (!goes_on(batch, thread, services, row, roulette)) {
            thread.finish(row);
            continue;
        }
        if (reads_words_) thread.words[row].push_back(event);
        Ray ray;
        ray.direction = s.wi;
        ray.origin = leave_surface(point.position, point.geometric_normal, thread.sources[j].offset, s.wi);
        thread.push_next(row, ray);
        ++thread.counters.scattering_rays;
    }
}

}  // namespace raylex::transport
