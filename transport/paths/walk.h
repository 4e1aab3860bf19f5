// Steps of a batched walk that camera and light subpaths share: rays to vertices, cutouts on the way.
#pragma once

#include "transport/paths/event_table.h"
#include "transport/paths/vertex.h"

namespace raylex::transport {

/// The closest hits of `queue` for which `arrives(row, ray, hit)` become `vertices`, all but their closures. It is asked
/// about every ray, those that hit nothing included; the queue is empty then, so that it may fill it.
template <class Arrives>
void trace(const EmbreeScene& geometry, RayQueue& queue, VertexBatch& vertices, Arrives arrives) {
    const std::size_t count = queue.count;
    queue.count = 0;
    geometry.intersect({queue.rays.data(), count}, {vertices.hits.data(), count});
    vertices.count = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t row = queue.rows[i];
        if (!arrives(row, queue.rays[i], vertices.hits[i])) continue;
        vertices.rows[vertices.count] = row;
        vertices.rays[vertices.count] = queue.rays[i];
        vertices.hits[vertices.count] = vertices.hits[i];
        ++vertices.count;
    }
    geometry.surfaces({vertices.rays.data(), vertices.count}, {vertices.hits.data(), vertices.count},
                      {vertices.points.data(), vertices.count}, {vertices.sources.data(), vertices.count});
}

/// The alpha test of vertex j, whose shape has alpha: whether the ray goes straight on. `u` in [0, 1): closest hit first,
/// then one counter-based choice, in expectation what alpha blending gives, and what pbrt does.
inline bool passes_alpha_test(const SceneView& scene, const VertexBatch& vertices, std::size_t j, float u) {
    const ShapeGeometry& shape = scene.geometry->shapes()[vertices.hits[j].shape];
    const SurfacePoint& point = vertices.points[j];
    return !(u < scene.textures->real(shape.alpha, {point.u, point.v, point.position}));
}

/// A ray that leaves vertex j.
inline Ray ray_from(const VertexBatch& vertices, std::size_t j, const Vec3& direction) {
    const SurfacePoint& point = vertices.points[j];
    Ray ray;
    ray.direction = direction;
    ray.origin = offset_ray_origin(point.position, point.geometric_normal, vertices.sources[j].offset, direction);
    return ray;
}

}  // namespace raylex::transport
