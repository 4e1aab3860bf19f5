#include "transport/paths/subpaths/camera_connections.h"

#include <cmath>

#include "transport/paths/subpaths/transmittance.h"

namespace raylex::transport {

UnconnectedSurfaces unconnected_surfaces(const SceneView& scene) {
    UnconnectedSurfaces found;
    std::vector<LobeId> lobes;
    for (const ShapeGeometry& shape : scene.geometry->shapes()) {
        if (shape.interface) continue;
        scene.materials->material(static_cast<std::size_t>(shape.material))->append_lobes(lobes);
        found.curves = found.curves || shape.faces_rays;
    }
    for (const LobeId lobe : lobes)
        found.specular = found.specular || lobe_kinds()[lobe].scatter == lpe::Scatter::singular;
    return found;
}

void CameraConnections::add(const LightSubpathVertex& vertex, const SurfacePoint& point, const Bsdf& bsdf,
                            const Rgb& throughput, const DepthLimit& limit, const PixelSampler& sampler,
                            IntegratorCounters& counters) {
    if (!vertex.live.seen) return counters.count(Pruned::connections);
    const CameraView view = context_.view;
    const SubpathDimensions& dimensions = subpath_dimensions<TransportMode::importance>;
    const Vec2 lens =
        view.camera->has_lens() ? sampler.get_2d(dimensions.of(vertex.depth, camera_lens_dimension)) : Vec2{0, 0};
    CameraConnection seen;
    if (!bsdf.has_density() || !view.camera->connect(point.position, lens, vertex.time, seen)) return;
    const auto reached = [](Real position, Real radius, int size) {
        return position > 0.5f - radius && position < static_cast<Real>(size) - 0.5f + radius;
    };
    if (!reached(seen.x, view.filter_radius.x, view.width) || !reached(seen.y, view.filter_radius.y, view.height))
        return;
    const Vec3 way = seen.position - point.position;
    // A camera closer to the plane of the surface than rounding may have moved the plane sees the surface edge-on:
    // nothing. No other strategy finds what the rounded cosine would give, and near the camera it adds up.
    if (abs_dot(way, point.geometric_normal) < vertex.offset.here) return;
    const Vec3 to_camera = normalize(way);
    if (!limit.allows(vertex.length.before + limit.event(vertex.length, point, to_camera))) return;
    const ConnectedScattering scattering =
        evaluate_scattering<TransportMode::importance, false>(context_.directions, bsdf, point, to_camera);
    const BsdfEvaluation& f = scattering.f;
    if (f.value.is_black()) return;
    const Real image_share = 1 / (static_cast<Real>(view.width) * static_cast<Real>(view.height));
    const Rgb unweighted = throughput * f.value * (seen.importance * image_share);
    Rgb value = unweighted;
    if (vertex.weighted) {
        const Real cosine = point.cosine(to_camera);
        value *= PartialMisWeights::weight(  // t = 1: Georgiev 2012, equation 46
            vertex.mis_weights.others(view.density(seen.importance, cosine),
                                      static_cast<double>(scattering.pdf_reverse)));
    }
    if (value.is_black()) return;
    pending_.push_back(
        {.row = vertex.row,
         .x = seen.x,
         .y = seen.y,
         .light_vertices = vertex.depth + 2,
         .holdout = vertex.holdout,
         .value = value,
         .unweighted = unweighted,
         .key = vertex.key,
         .end = vertex.end,
         .from_camera = segment_to(seen.position, point.position, point.geometric_normal, vertex.offset)});
    pending_.back().end.lobes = f.lobes;
    pending_.back().from_camera.time = vertex.time;
    // From the surface: the bound of the intersector's rounding there does not hold for a ray that comes from afar.
    Ray ray;
    ray.origin = offset_ray_origin(point.position, point.geometric_normal, vertex.offset.here, to_camera);
    ray.direction = seen.position - ray.origin;
    ray.t_max = end_of_segment;
    ray.time = vertex.time;
    shadow_rays_.push_back(ray);
}

/// Leaves out connections that no channel accepts (Law 4). Only without beauty, and without cutouts, whose events come
/// before those of `end`.
void CameraConnections::drop_dead(ThreadServices& services, IntegratorCounters& counters) {
    Record record(*context_.events);
    record.begin(services.lpe);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < pending_.size(); ++i) {
        if (!record.is_live_splat(pending_[i].row, pending_[i].end)) {
            counters.count(Pruned::shadow_rays);
            continue;
        }
        pending_[kept] = pending_[i];
        shadow_rays_[kept++] = shadow_rays_[i];
    }
    pending_.resize(kept);
    shadow_rays_.resize(kept);
}

void CameraConnections::splat(std::span<const display::CameraRow> rows, ThreadServices& services,
                              IntegratorCounters& counters) {
    const SceneView& scene = context_.scene;
    const EmbreeScene& geometry = *scene.geometry;
    if (!context_.beauty && !geometry.has_alpha()) drop_dead(services, counters);
    display::RasterSplats& raster = *services.raster;
    Record record(*context_.events);
    record.begin(raster.lpe());
    const std::size_t count = pending_.size();
    counters.shadow_rays += count;
    blocked_.resize(std::max(blocked_.size(), count));
    geometry.occluded(shadow_rays_, {blocked_.data(), count});
    for (std::size_t i = 0; i < count; ++i) {
        if (blocked_[i]) continue;
        const Pending& p = pending_[i];
        display::Tracker tracker = raster.begin(to_float(p.x), to_float(p.y), rows[p.row]);
        if (p.holdout) record.hold_out(tracker);
        Arrival arrival;
        arrival.value = p.value;
        arrival.unweighted = p.unweighted;
        arrival.sampled_too = true;
        if (scene.tests_alpha() || scene.asks_for_media()) {
            Rgb transmittance(1);
            arrival.visibility = pass_through_transmittance(
                {.scene = scene, .record = record, .counters = counters, .numbers = FlightNumbers(p.key)},
                p.from_camera, 1, scene.media->camera(), tracker, transmittance);
            arrival.value *= transmittance * arrival.visibility;
            arrival.unweighted *= transmittance;
        }
        record.reach(tracker, p.end);
        record.add(tracker, {p.light_vertices, 1}, arrival);
    }
    clear();
}

}  // namespace raylex::transport
