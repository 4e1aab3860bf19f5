#include "transport/paths/subpaths/camera_connections.h"

#include <cmath>

#include "transport/paths/subpaths/transmittance.h"

namespace raylex::transport {

void CameraConnections::add(const CameraView& view, const DepthLimit& limit, const LightSubpathEnd& end,
                            const Vec2& lens) {
    const SurfacePoint& point = *end.point;
    CameraConnection seen;
    if (!end.bsdf->has_density() || !view.camera->connect(point.position, lens, end.time, seen)) return;
    const auto reached = [](Real position, Real radius, int size) {
        return position > 0.5f - radius && position < static_cast<Real>(size) - 0.5f + radius;
    };
    if (!reached(seen.x, view.filter_radius.x, view.width) || !reached(seen.y, view.filter_radius.y, view.height))
        return;
    const Vec3 way = seen.position - point.position;
    // A camera no farther from the surface's plane than rounding may have moved that sees it edge-on: nothing. What the
    // rounded cosine would give instead no other strategy finds, and near the camera it adds up.
    if (abs_dot(way, point.geometric_normal) < end.offset.here) return;
    const Vec3 to_camera = normalize(way);
    if (!limit.allows(end.length.before + limit.event(end.length, point, to_camera))) return;
    const JoinedScattering scattering =
        evaluate_scattering<TransportMode::importance, false>(*end.bsdf, point, to_camera);
    const BsdfEvaluation& f = scattering.f;
    if (f.value.is_black()) return;
    const Real image_share = 1 / (static_cast<Real>(view.width) * static_cast<Real>(view.height));
    const Rgb unweighted = end.power * f.value * (seen.importance * image_share);
    Rgb value = unweighted;
    if (end.sums != nullptr) {
        const Real cosine = point.cosine(to_camera);
        value *= StrategySums::weight(
            end.sums->others(view.density(seen.importance, cosine), static_cast<double>(scattering.pdf_reverse)));
    }
    if (value.is_black()) return;
    pending_.push_back({end.row, seen.x, seen.y, end.depth + 2, end.holdout, value, unweighted, end.key, end.end,
                        segment_to(seen.position, point.position, point.geometric_normal, end.offset)});
    pending_.back().end.lobes = f.lobes;
    pending_.back().from_camera.time = end.time;
    // From the surface: what bounds the intersector's rounding there would not do for a ray that comes from afar.
    Ray ray;
    ray.origin = offset_ray_origin(point.position, point.geometric_normal, end.offset.here, to_camera);
    ray.direction = seen.position - ray.origin;
    ray.t_max = end_of_segment;
    ray.time = end.time;
    shadow_rays_.push_back(ray);
}

void CameraConnections::drop_dead(const Record& record, IntegratorCounters& counters) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < pending_.size(); ++i) {
        if (!record.worth_splatting(pending_[i].row, pending_[i].end)) {
            counters.count(Pruned::shadow_rays);
            continue;
        }
        pending_[kept] = pending_[i];
        shadow_rays_[kept++] = shadow_rays_[i];
    }
    pending_.resize(kept);
    shadow_rays_.resize(kept);
}

void CameraConnections::splat(const SceneView& scene, const EventTable& events,
                              std::span<const display::CameraRow> rows, display::RasterSplats& raster,
                              IntegratorCounters& counters) {
    const EmbreeScene& geometry = *scene.geometry;
    Record record(events);
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
        arrival.found_by_sampling = true;
        if (scene.tests_alpha() || scene.asks_for_media()) {
            Rgb transmittance(1);
            arrival.visibility =
                straight_transmittance({scene, record, counters, false, FlightNumbers(p.key)}, p.from_camera, 1,
                                       scene.media->camera(), tracker, transmittance);
            arrival.value *= transmittance * arrival.visibility;
            arrival.unweighted *= transmittance;
        }
        record.reach(tracker, p.end);
        record.add(tracker, {p.light_vertices, 1}, arrival);
    }
    clear();
}

}  // namespace raylex::transport
