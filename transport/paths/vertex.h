// Path vertices of a batch, one level of every subpath side by side, and the rays that lead to the next.
#pragma once

#include <cstdint>
#include <vector>

#include "transport/geometry/embree_scene.h"
#include "transport/materials/closure.h"

namespace raylex::transport {

/// Rays on their way to the next vertices.
struct RayQueue {
    std::vector<std::uint32_t> rows;   ///< whose subpath
    std::vector<Ray> rays;
    std::size_t count = 0;

    void reserve(std::size_t n) {
        rows.resize(n);
        rays.resize(n);
    }
    void push(std::uint32_t row, const Ray& ray) {
        rows[count] = row;
        rays[count++] = ray;
    }
};

/// Surface hits, compact: entry j of every array is one subpath.
struct VertexBatch {
    std::vector<std::uint32_t> rows;
    std::vector<Ray> rays;
    std::vector<Hit> hits;
    std::vector<SurfacePoint> points;
    std::vector<SurfaceSource> sources;
    std::vector<Bsdf> bsdfs;
    std::size_t count = 0;

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

}  // namespace raylex::transport
