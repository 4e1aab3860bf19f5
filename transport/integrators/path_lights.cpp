// The path integrator's light samples.
#include "transport/integrators/path_state.h"
#include "transport/paths/transmittance.h"
#include "transport/math/sampling.h"

namespace raylex::transport {

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
        if (cutouts) sample.radiance *= emitter_opacity(context_.scene, sample, v.points[j].position);
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
        if (in_media_)
            thread.light_media[thread.pending_count] = {
                context_.scene.geometry->shapes()[v.hits[j].shape].medium_towards(v.points[j].geometric_normal,
                                                                                  sample.wi, thread.media[row]),
                -1};
        if (!cutouts && !services.lpe.takes_all(thread.trackers[row])) {
            // Only channels matter: a light whose group no channel can still accept is not worth a ray (Law 4), nor is
            // one whose shadows nobody sees.
            const lpe::EventClass terminal = context_.events->terminal(sample.light);
            display::Tracker ahead = thread.trackers[row];
            move_by_lobes(ahead, services.lpe, *context_.events, v.sources[j].label, f.lobes);
            if (!services.lpe.live_after(ahead, terminal)) continue;
            services.lpe.move(ahead, terminal);
            if (with_emitters && !in_media_ && !services.lpe.needs_visibility(ahead)) {
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

void PathIntegrator::add_lights(PathThread& thread, ThreadServices& services) const {
    if (thread.pending_count == 0) return;
    const EmbreeScene& geometry = *context_.scene.geometry;
    geometry.occluded({thread.shadow_rays.data(), thread.pending_count}, {thread.blocked.data(), thread.pending_count});
    const bool with_emitters = services.lpe.wants_emitter_samples();
    const bool straight = geometry.has_alpha() || in_media_;
    const bool to_the_end = in_media_ && with_emitters;  // `through` counts without shadows too
    for (std::size_t i = 0; i < thread.pending_count; ++i) {
        if (thread.blocked[i] && !with_emitters) continue;
        const PendingLight& pending = thread.pending[i];
        const PendingLightMedia media = in_media_ ? thread.light_media[i] : PendingLightMedia();
        display::Tracker tracker = thread.trackers[pending.row];
        if (media.scattered >= 0) services.lpe.move(tracker, context_.events->phase(media.scattered));
        else move_by_lobes(tracker, services.lpe, *context_.events, pending.label, pending.lobes);
        Rgb value = pending.value, through(1);
        float visible = thread.blocked[i] ? 0.0f : 1.0f;
        if (straight && (!thread.blocked[i] || in_media_)) {
            visible = straight_transmittance({context_.scene, *context_.events, services.lpe, thread.counters, to_the_end},
                                             thread.shadow_rays[i], visible, media.along, tracker, through);
            if (!(visible > 0) && !with_emitters) continue;
            value *= visible;
            if (in_media_) value *= through;
        }
        services.lpe.move(tracker, context_.events->terminal(pending.light));
        if (!with_emitters) {
            services.lpe.contribute(value, display::Technique::light_sampling, tracker);
            continue;
        }
        display::EmitterSample emitter = thread.emitters[i];
        emitter.visibility = visible;
        if (in_media_) emitter.unweighted *= through;
        services.lpe.contribute(visible > 0 ? value : Rgb(), display::Technique::light_sampling, tracker, emitter);
    }
}

}  // namespace raylex::transport
