#include "transport/paths/camera_connections.h"

#include <cmath>

#include "transport/paths/transmittance.h"

namespace raylex::transport {

void CameraConnections::add(const CameraView& view, const LightSubpathEnd& end,
                            const Vec2& lens) {
    const SurfacePoint& point = *end.point;
    CameraConnection seen;
    if (!end.bsdf->has_density() || !view.camera->connect(point.position, lens, seen)) return;
    const auto reached = [](float position, float radius, int size) {
        return position > 0.5f - radius && position < static_cast<float>(size) - 0.5f + radius;
    };
    if (!reached(seen.x, view.filter_radius.x, view.width) || !reached(seen.y, view.filter_radius.y, view.height))
        return;
    const Vec3 to_camera = normalize(seen.position - point.position);
    const JoinedScattering f = evaluate_scattering(TransportMode::importance, *end.bsdf, point, to_camera, false);
    if (f.value.is_black()) return;
    const float image_share = 1 / (static_cast<float>(view.width) * static_cast<float>(view.height));
    Rgb value = end.power * f.value * (seen.importance * image_share);
    if (end.sums != nullptr) {
        const float cosine = std::abs(dot(point.geometric_normal, to_camera));
        value *= StrategySums::weight(
            end.sums->others(view.density(seen.importance, cosine), static_cast<double>(f.pdf_reverse)));
    }
    if (value.is_black()) return;
    pending_.push_back({end.row, end.light, end.label, seen.x, seen.y, value, f.lobes, end.word});
    // From the camera, so that cutouts come in the order in which its word reads them.
    Ray ray;
    ray.origin = seen.position;
    ray.direction = offset_ray_origin(point.position, point.geometric_normal, end.offset, to_camera) - ray.origin;
    ray.t_max = shadow_t_max;
    shadow_rays_.push_back(ray);
}

void CameraConnections::drop_dead(const EventTable& events, display::LpeServices& lpe) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < pending_.size(); ++i) {
        const Pending& p = pending_[i];
        display::Tracker tracker = lpe.begin(static_cast<int>(p.row));
        move_by_lobes(tracker, lpe, events, p.label, p.lobes);
        move_to_light(tracker, lpe, events, p.word, p.light);
        if (!lpe.channels_follow(tracker)) continue;
        pending_[kept] = p;
        shadow_rays_[kept++] = shadow_rays_[i];
    }
    pending_.resize(kept);
    shadow_rays_.resize(kept);
}

void CameraConnections::splat(const SceneView& scene, const EventTable& events,
                              std::span<const display::CameraRow> rows, display::RasterSplats& raster,
                              IntegratorCounters& counters) {
    const EmbreeScene& geometry = *scene.geometry;
    const std::size_t count = pending_.size();
    counters.shadow_rays += count;
    blocked_.resize(std::max(blocked_.size(), count));
    geometry.occluded(shadow_rays_, {blocked_.data(), count});
    for (std::size_t i = 0; i < count; ++i) {
        if (blocked_[i]) continue;
        const Pending& p = pending_[i];
        display::Tracker tracker = raster.begin(p.x, p.y, rows[p.row]);
        Rgb value = p.value, through(1);
        if (geometry.has_alpha())
            value *= straight_transmittance({scene, events, raster.lpe(), counters}, shadow_rays_[i], 1, -1, tracker,
                                            through);
        if (events.any()) {
            move_by_lobes(tracker, raster.lpe(), events, p.label, p.lobes);
            move_to_light(tracker, raster.lpe(), events, p.word, p.light);
        }
        raster.lpe().contribute(value, display::Technique::light_tracing, tracker);
    }
    clear();
}

}  // namespace raylex::transport
