// From first hits to the shading batch that geometric AOVs read.
#pragma once

#include <cstdint>
#include <span>

#include "geoaovs/geoaovs.h"
#include "transport/paths/path_context.h"
#include "transport/paths/vertex.h"

namespace raylex::transport {

/// First hits side by side: entry `which[i]` of every array is one. Those must not be empty that the render's AOVs
/// read; to fill them all is always right.
struct FirstHits {
    std::span<const std::uint32_t> which;
    std::span<const std::uint32_t> rows;  ///< in the sample table
    std::span<const Ray> rays;
    std::span<const Hit> hits;
    std::span<const SurfacePoint> points;
    std::span<const SurfaceSource> sources;
    std::span<const Bsdf> bsdfs;
};

/// Geometric AOVs of the vertices `which`, by way of `batch`.
void write_first_hits(const PathContext& context, const VertexBatch& vertices, std::span<const std::uint32_t> which,
                      geoaovs::ShadingBatch& batch, display::DisplayServices& display);

/// Makes `batch` these hits. Only the columns that the render's AOVs read are filled.
void describe_first_hits(const PathContext& context, const FirstHits& first, geoaovs::ShadingBatch& batch);

/// How far `position` lies from the nearest of the edges (start and end by turns), in pixels of the image; infinity
/// when there is none. Edges that pass behind the camera are cut.
Real edge_distance(const FirstHitSetup& setup, const Vec3& position, std::span<const Vec3> edges);

}  // namespace raylex::transport
