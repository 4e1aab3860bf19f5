// Path vertices of a batch, one level of every subpath side by side, and the rays that lead to the next.
#pragma once

#include <cstdint>
#include <vector>

#include "transport/embree/embree_scene.h"
#include "transport/materials/closures/closure.h"
#include "transport/paths/event_table.h"

namespace raylex::transport {

/// Rays on their way to the next vertices.
struct RayQueue {
    std::vector<std::uint32_t> rows;  ///< the subpath of each ray
    std::vector<Ray> rays;
    std::size_t count = 0;

    void reserve(std::size_t n) {
        rows.resize(n);
        rays.resize(n);
    }
    void push(std::uint32_t row, const Ray& ray) { next(row) = ray; }
    /// Adds a ray, which the caller fills in.
    Ray& next(std::uint32_t row) {
        rows[count] = row;
        return rays[count++];
    }
};

/// Entry j of every array is one subpath: surface hits first, then collisions with particles of media. Collisions have
/// rows, points (SurfacePoint::no_material), sources (the medium's label), bsdfs (the phase function) and time and cone
/// of hits. Their other entries are unset.
struct VertexBatch {
    std::vector<std::uint32_t> rows;
    std::vector<Ray> rays;
    std::vector<Hit> hits;
    std::vector<SurfacePoint> points;
    std::vector<SurfaceSource> sources;
    std::vector<Bsdf> bsdfs;
    std::vector<SurfaceFootprint> footprints;  ///< of points that have one
    std::size_t surfaces = 0, count = 0;

    void reserve(std::size_t n) {
        rows.resize(n);
        rays.resize(n);
        hits.resize(n);
        points.resize(n);
        sources.resize(n);
        bsdfs.resize(n);
    }
    /// Entry `from` moves to `to` (before materials have run).
    void keep(std::size_t from, std::size_t to) {
        if (from == to) return;
        rows[to] = rows[from];
        rays[to] = rays[from];
        hits[to] = hits[from];
        points[to] = points[from];
        sources[to] = sources[from];
    }
};

/// A ray that leaves vertex j, with the time and the cone of the ray that led there.
inline Ray ray_from(const VertexBatch& vertices, std::size_t j, const Vec3& direction) {
    const SurfacePoint& point = vertices.points[j];
    Ray ray;
    ray.direction = direction;
    ray.time = vertices.hits[j].time;
    ray.cone = vertices.hits[j].cone;
    ray.origin =
        point.material == SurfacePoint::no_material
            ? point.position
            : offset_ray_origin(point.position, point.geometric_normal, vertices.sources[j].offset.here, direction);
    return ray;
}

/// Applies bump and normal maps to the shading normals of `points`, whose `random_key` is set. Closures, lights and
/// AOVs all use the resulting normals.
inline void apply_bump(const SceneView& scene, std::span<const Hit> hits, std::span<SurfacePoint> points) {
    for (std::size_t j = 0; j < hits.size(); ++j) {
        const NormalDetail& detail = scene.materials->normal_detail(*scene.textures, points[j]);
        if (detail.empty()) continue;
        detail.apply(*scene.textures, scene.geometry->tangents(hits[j], points[j]), hits[j].cone.width, points[j]);
    }
}

}  // namespace raylex::transport
