// Rays through Embree, in batches.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "transport/embree/embree_device.h"

namespace raylex::transport {
namespace {

void to_embree(const Ray& ray, unsigned mask, RTCRay& r) {
    r.org_x = to_float(ray.origin.x);
    r.org_y = to_float(ray.origin.y);
    r.org_z = to_float(ray.origin.z);
    // Not 0: Embree accepts a hit at the lower end, and the distance to the surface that a ray has left may underflow
    // to 0.
    r.tnear = std::numeric_limits<float>::min();
    r.dir_x = to_float(ray.direction.x);
    r.dir_y = to_float(ray.direction.y);
    r.dir_z = to_float(ray.direction.z);
    r.time = to_float(ray.time);
    r.tfar = to_float(ray.t_max);
    r.mask = mask;
    r.id = 0;
    r.flags = 0;
}

/// Copies Embree's numbers; finish_hits() replaces them by ours.
void hit_of(const RTCRayHit& found, const Ray& ray, Hit& hit) {
    hit.t = found.ray.tfar;
    hit.u = found.hit.u;
    hit.v = found.hit.v;
    hit.shape = found.hit.geomID;  // no hit: Hit::none
    hit.primitive = found.hit.primID;
    hit.instance = found.hit.instID[0];
    hit.time = ray.time;
    hit.cone = ray.cone;
}

}  // namespace

/// Embree ends the program if a coordinate of a ray is out of its range, in the world's space or an instance's.
bool EmbreeScene::traceable(const Ray& ray) const {
    // The number of coordinates within the range: one branch for six comparisons.
    const auto fitting = [&](const Vec3& v) {
        return (std::abs(v.x) <= ray_limit_) + (std::abs(v.y) <= ray_limit_) + (std::abs(v.z) <= ray_limit_);
    };
    if (fitting(ray.origin) + fitting(ray.direction) == 6) [[likely]]
        return true;
    device_->untraced.fetch_add(1, std::memory_order_relaxed);
    return false;
}

std::uint64_t EmbreeScene::untraced_rays() const {
    return device_->untraced.load(std::memory_order_relaxed);
}

/// Prefetches the memory that finish_hits() reads, while the next rays are traced: large meshes do not fit into caches.
/// `hit` uses Embree's ids.
void EmbreeScene::fetch_primitive(const Hit& hit) const {
    if (!hit.valid()) return;
    const std::size_t first = hit.instance == Hit::none ? 0 : instances_[hit.instance - top_level_shapes_].first_shape;
    const ShapeGeometry& shape = shapes_[first + hit.shape];
    if (shape.kind == ShapeKind::triangle_mesh) __builtin_prefetch(&shape.triangles[hit.primitive]);
}

void EmbreeScene::intersect(std::span<const Ray> rays, std::span<Hit> hits) const {
    if (log_ != nullptr) log_->add(rays, false);
    RayQuery query;
    RTCRayHit rayhit;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        Hit& hit = hits[i];
        if (!traceable(rays[i])) [[unlikely]] {
            hit = Hit();
            continue;
        }
        to_embree(rays[i], any_mask, rayhit.ray);
        rayhit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        rayhit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        query.closest(device_->scene, rayhit);
        hit_of(rayhit, rays[i], hit);
        fetch_primitive(hit);
    }
    // A separate loop, so that the processor overlaps several hits.
    finish_hits(rays, hits);
}

void EmbreeScene::intersect_alpha(const Ray& ray, Hit& hit) const {
    RayQuery query;
    RTCRayHit rayhit;
    if (!traceable(ray)) [[unlikely]] {
        hit = Hit();
        return;
    }
    to_embree(ray, alpha_mask, rayhit.ray);
    rayhit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rayhit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    query.closest(device_->scene, rayhit);
    hit_of(rayhit, ray, hit);
    finish_hits({&ray, 1}, {&hit, 1});
}

void EmbreeScene::occluded(std::span<const Ray> rays, std::span<std::uint8_t> blocked) const {
    if (log_ != nullptr) log_->add(rays, true);
    RayQuery query;
    std::array<RTCRay, 64> stream;
    for (std::size_t first = 0; first < rays.size(); first += stream.size()) {
        const std::size_t count = std::min(stream.size(), rays.size() - first);
        for (std::size_t i = 0; i < count; ++i) {
            to_embree(rays[first + i], opaque_mask, stream[i]);
            if (!traceable(rays[first + i])) [[unlikely]]
                stream[i].tfar = -infinity;  // Embree's mark of a blocked ray; it skips such rays
        }
        if (!streams_ || !query.shadow_stream(device_->scene, {stream.data(), count}))
            for (std::size_t i = 0; i < count; ++i)
                if (stream[i].tfar > 0) query.shadow(device_->scene, stream[i]);
        for (std::size_t i = 0; i < count; ++i) blocked[first + i] = stream[i].tfar < 0;
    }
}

std::uint64_t EmbreeScene::trace_bare(const RayLog& log) const {
    RayQuery query;
    std::uint64_t hits = 0;
    const Ray* next = log.rays.data();
    for (const RayLog::Batch& batch : log.batches) {
        const Ray* const end = next + batch.count;
        if (batch.shadow) {
            for (; next != end; ++next) {
                RTCRay ray;
                to_embree(*next, opaque_mask, ray);
                query.shadow(device_->scene, ray);
                hits += ray.tfar < 0 ? 1 : 0;
            }
            continue;
        }
        for (; next != end; ++next) {
            RTCRayHit rayhit;
            to_embree(*next, any_mask, rayhit.ray);
            rayhit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
            rayhit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
            query.closest(device_->scene, rayhit);
            hits += rayhit.hit.geomID != RTC_INVALID_GEOMETRY_ID ? 1 : 0;
        }
    }
    return hits;
}

static_assert(Hit::none == RTC_INVALID_GEOMETRY_ID);

}  // namespace raylex::transport
