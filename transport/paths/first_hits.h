// From first hits to the shading batch that geometric AOVs read.
#pragma once

#include <cstdint>
#include <span>

#include "geoaovs/geoaovs.h"
#include "transport/paths/path_context.h"
#include "transport/paths/vertex.h"

namespace raylex::transport {

/// First hits as a structure of arrays, of which `which` lists the entries that are first hits. Arrays that the AOVs of
/// the render read must be filled; the others may be empty.
struct FirstHits {
    std::span<const std::uint32_t> which;
    std::span<const std::uint32_t> rows;  ///< in the sample table
    std::span<const Ray> rays;
    std::span<const Hit> hits;
    std::span<const SurfacePoint> points;
    std::span<const SurfaceSource> sources;
    std::span<const Bsdf> bsdfs;
};

/// Writes geometric AOVs of the vertices `which`. `batch` is scratch memory.
void write_first_hits(const PathContext& context, const VertexBatch& vertices, std::span<const std::uint32_t> which,
                      geoaovs::ShadingBatch& batch, display::DisplayServices& display);

/// Fills `batch` with the first hits. Only the columns that the render's AOVs read are filled.
void describe_first_hits(const PathContext& context, const FirstHits& first, geoaovs::ShadingBatch& batch);

/// Distance from `position` to the nearest edge, in pixels of the image; infinity if there are no edges. `edges`
/// alternates start and end points. An edge that passes behind the camera is cut there.
Real edge_distance(const FirstHitSetup& setup, const Vec3& position, std::span<const Vec3> edges);

}  // namespace raylex::transport
