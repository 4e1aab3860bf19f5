// The light tracer's connections to the camera.
#include <cmath>

#include "transport/integrators/light_tracer_state.h"
#include "transport/integrators/straight.h"

namespace raylex::transport {
namespace {

void move(display::Tracker& tracker, display::LpeServices& lpe, const EventTable& events, std::int32_t label,
          const LobeList& lobes) {
    std::array<display::LobePart, max_lobes> parts;
    for (std::size_t i = 0; i < static_cast<std::size_t>(lobes.count); ++i)
        parts[i] = {events.scatter(label, lobes.entry[i].lobe), lobes.entry[i].value};
    lpe.move(tracker, {parts.data(), static_cast<std::size_t>(lobes.count)});
}

}  // namespace

void LightTracer::read_word(display::Tracker& tracker, display::LpeServices& lpe, const LightThread& thread,
                            const PendingSplat& splat) const {
    if (!reads_words_) return;
    move(tracker, lpe, *context_.events, splat.label, splat.lobes);
    const std::vector<WordEvent>& word = thread.words[splat.row];
    for (auto event = word.rbegin(); event != word.rend() && lpe.channels_follow(tracker); ++event) {
        if (event->straight) lpe.move(tracker, context_.events->straight(event->label));
        else move(tracker, lpe, *context_.events, event->label, event->lobes);
    }
    lpe.move(tracker, context_.events->terminal(thread.paths[splat.row].light));
}

void LightTracer::connect(const CameraBatch& batch, LightThread& thread, ThreadServices& services) const {
    thread.pending_count = 0;
    const PerspectiveCamera& camera = *context_.camera;
    const bool cutouts = context_.scene.geometry->has_alpha();
    const float image_share = 1 / (static_cast<float>(context_.width) * static_cast<float>(context_.height));
    const auto reached = [](float position, float radius, int size) {
        return position > 0.5f - radius && position < static_cast<float>(size) - 0.5f + radius;
    };
    for (std::size_t j = 0; j < thread.count; ++j) {
        const Bsdf& bsdf = thread.bsdfs[j];
        if (!bsdf.has_density()) continue;
        const std::uint32_t row = thread.rows[j];
        const LightPath& path = thread.paths[row];
        const SurfacePoint& point = thread.points[j];
        const Vec2 lens =
            camera.has_lens() ? batch.samplers[row].get_2d(dimension(path, camera_lens_dimension)) : Vec2{0, 0};
        CameraConnection seen;
        if (!camera.connect(point.position, lens, seen)) continue;
        if (!reached(seen.x, context_.filter_radius.x, context_.width) ||
            !reached(seen.y, context_.filter_radius.y, context_.height))
            continue;
        const Vec3 to_camera = normalize(seen.position - point.position);
        const BsdfEvaluation f = bsdf.evaluate(to_camera, point.wo);
        if (f.value.is_black()) continue;
        const float g_in = std::abs(dot(point.geometric_normal, point.wo)),
                    g_out = std::abs(dot(point.geometric_normal, to_camera));
        if (!(g_in > 0)) continue;
        PendingSplat& splat = thread.pending[thread.pending_count];
        splat = {row, thread.sources[j].label, seen.x, seen.y, path.power * f.value * (g_out / g_in * seen.importance * image_share),
                 f.lobes};
        if (splat.value.is_black()) continue;
        if (!context_.beauty && !cutouts) {  // Law 4: cutouts on the way would leave events of their own
            display::Tracker tracker = services.lpe.begin(static_cast<int>(row));
            read_word(tracker, services.lpe, thread, splat);
            if (!services.lpe.channels_follow(tracker)) continue;
        }
        // From the camera, so that cutouts come in the order in which its word reads them.
        Ray& ray = thread.shadow_rays[thread.pending_count++];
        ray = Ray();
        ray.origin = seen.position;
        ray.direction = leave_surface(point.position, point.geometric_normal, thread.sources[j].offset, to_camera) - ray.origin;
        ray.t_max = shadow_t_max;
    }
    thread.counters.shadow_rays += thread.pending_count;
}

void LightTracer::add_splats(const CameraBatch& batch, LightThread& thread, ThreadServices& services) const {
    if (thread.pending_count == 0) return;
    const EmbreeScene& geometry = *context_.scene.geometry;
    geometry.occluded({thread.shadow_rays.data(), thread.pending_count}, {thread.blocked.data(), thread.pending_count});
    display::RasterSplats& raster = *services.raster;
    for (std::size_t i = 0; i < thread.pending_count; ++i) {
        if (thread.blocked[i]) continue;
        const PendingSplat& splat = thread.pending[i];
        display::Tracker tracker = raster.begin(splat.x, splat.y, batch.rows[splat.row]);
        Rgb value = splat.value, through(1);
        if (geometry.has_alpha())
            value *= straight_transmittance({context_.scene, *context_.events, raster.lpe(), thread.counters},
                                            thread.shadow_rays[i], 1, -1, tracker, through);
        read_word(tracker, raster.lpe(), thread, splat);
        raster.lpe().contribute(value, display::Technique::light_tracing, tracker);
    }
}

}  // namespace raylex::transport
