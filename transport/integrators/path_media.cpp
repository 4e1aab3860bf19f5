// The path integrator in participating media: how far paths fly, what glows on the way, and scattering by particles.
//
// A collision is drawn by extinction and weighed by the albedo. Where nothing that the medium scatters can count (it only
// absorbs, the path has had its last scattering, no channel follows V), no choice is made and the path goes on with the
// transmittance: exact Beer-Lambert. A medium's own glow along a segment has a closed form, so it adds no noise.
//
// Depth of a camera ray: a collision stops it there, opaque, as a surface would; the mean over many rays is the medium's
// opacity. A medium that only absorbs stops none: an extra sample takes the share it absorbs. Opacity of coloured media
// is right in the mean over the colours, as alpha is.
#include "transport/integrators/path_state.h"
#include "transport/paths/transmittance.h"
#include "transport/media/phase.h"

namespace raylex::transport {

bool PathIntegrator::worth_colliding(const PathState& path, const display::Tracker& tracker, std::int32_t medium,
                                     const display::LpeServices& lpe) const {
    if (!(*context_.scene.media)[medium].scatters) return false;
    if (path.depth == 0) return true;  // the camera ray's depth and opacity are to be found
    return path.depth < parameters_.max_depth &&
           (lpe.takes_all(tracker) || lpe.live_after(tracker, context_.events->phase(medium)));
}

bool PathIntegrator::cross_medium(PathThread& thread, ThreadServices& services, std::uint32_t row, const Ray& ray,
                         std::int32_t medium, float distance) const {
    const Medium& m = (*context_.scene.media)[medium];
    PathState& path = thread.paths[row];
    const display::Tracker& tracker = thread.trackers[row];
    if (m.emits && path.depth >= parameters_.first_depth) {
        display::Tracker at_emission = tracker;
        services.lpe.move(at_emission, context_.events->emission());
        const Rgb emitted = emission_along(m, distance);
        services.lpe.contribute(path.beta * emitted, display::Technique::scattering, at_emission,
                                {emitted, path.beta * emitted, 1, false});
    }
    const Vec2 u = thread.samplers[row].get_2d(flight_dimensions + path.segment);
    if (!worth_colliding(path, tracker, medium, services.lpe)) {
        const Rgb passed = transmittance(m, distance);
        if (path.depth == 0 && passed.average() < 1)
            services.display.add_sample(static_cast<int>(row), {path.travelled + sample_absorption(m, distance, u),
                                                                RgbD(Rgb(1) - passed), true});
        path.beta *= passed;
        if (path.depth == 0 || !path.beta.is_black()) return true;
        thread.finish(row);
        return false;
    }
    const FreeFlight flight = sample_free_flight(m, path.beta, distance, u);
    path.beta *= flight.weight;
    if (!flight.collided) return true;
    if (path.depth == 0) {
        services.display.write_distance(static_cast<int>(row), path.travelled + flight.distance, true);
        services.display.write_opacity(static_cast<int>(row), Rgb(1));
    }
    if (path.depth >= parameters_.max_depth || path.beta.is_black()) {
        thread.finish(row);
        return false;
    }
    thread.collisions.add(row, ray.origin + ray.direction * flight.distance, ray.direction);
    return false;
}

void PathIntegrator::sample_lights_in_media(PathThread& thread, ThreadServices& services) const {
    if (!can_sample_lights_) return;
    const CollisionBatch& c = thread.collisions;
    const LightTable& lights = *context_.scene.lights;
    const bool own_choice = lights.needs_choice_number(choice());
    const bool with_emitters = services.lpe.wants_emitter_samples();
    const std::size_t before = thread.pending_count;
    for (std::size_t k = 0; k < c.count; ++k) {
        const std::uint32_t row = c.rows[k];
        const PathState& path = thread.paths[row];
        const PixelSampler& sampler = thread.samplers[row];
        const std::int32_t medium = thread.media[row];
        const float u_choice = own_choice ? sampler.get_1d(dimension(path, choice_dimension)) : 0.0f;
        LightSample sample;
        if (!lights.sample(choice(), *context_.scene.geometry, c.positions[k], u_choice,
                           sampler.get_2d(dimension(path, light_dimension)), sample))
            continue;
        if (parameters_.strategy == PathStrategy::scattering && !sample.delta) continue;
        sample.radiance *= emitter_opacity(context_.scene, sample, c.positions[k]);
        const float phase = phase_pdf((*context_.scene.media)[medium].g, c.forward[k], sample.wi);
        float weight = 1;
        if (!sample.delta && parameters_.strategy == PathStrategy::mis) weight = power_heuristic(sample.pdf, phase);
        const Rgb unweighted = path.beta * sample.radiance * (phase / sample.pdf);
        const Rgb value = unweighted * weight;
        if (value.is_black() && (!with_emitters || unweighted.is_black())) continue;
        if (!services.lpe.takes_all(thread.trackers[row])) {  // Law 4, as for surfaces; cutouts leave events of their own
            display::Tracker ahead = thread.trackers[row];
            services.lpe.move(ahead, context_.events->phase(medium));
            const bool straight = context_.scene.geometry->has_alpha();
            if (straight ? !services.lpe.live(ahead) : !services.lpe.live_after(ahead, context_.events->terminal(sample.light)))
                continue;
        }
        if (with_emitters)
            thread.emitters[thread.pending_count] = {lights.emitted(sample, c.positions[k]), unweighted, 1, false};
        thread.light_media[thread.pending_count] = {medium, medium};
        thread.pending[thread.pending_count] = {row, sample.light, 0, value, {}};
        thread.shadow_rays[thread.pending_count++] = shadow_ray(c.positions[k], Vec3(), 0, sample);
    }
    thread.counters.shadow_rays += thread.pending_count - before;
}

void PathIntegrator::scatter_in_media(PathThread& thread, ThreadServices& services) const {
    const CollisionBatch& c = thread.collisions;
    for (std::size_t k = 0; k < c.count; ++k) {
        const std::uint32_t row = c.rows[k];
        PathState& path = thread.paths[row];
        const std::int32_t medium = thread.media[row];
        const PhaseSample s = sample_phase((*context_.scene.media)[medium].g, c.forward[k],
                                           thread.samplers[row].get_2d(dimension(path, scatter_dimension)));
        const std::uint32_t roulette = dimension(path, roulette_dimension);
        ++path.depth;
        ++path.segment;
        path.specular_bounce = false;
        path.scatter_pdf = s.pdf;
        path.from = c.positions[k];
        services.lpe.move(thread.trackers[row], context_.events->phase(medium));
        if (!goes_on(thread, services, row, roulette)) continue;
        Ray ray;
        ray.direction = s.wi;
        ray.origin = c.positions[k];
        thread.queue.push(row, ray);
        ++thread.counters.scattering_rays;
    }
}

}  // namespace raylex::transport
