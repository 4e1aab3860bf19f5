// From first hits to the shading batch that geometric AOVs read: what every integrator that starts at the camera does.
#pragma once

#include <span>

#include "geoaovs/geoaovs.h"
#include "transport/integrators/integrator.h"

namespace raylex::transport {

/// One first hit of a batch.
struct FirstHit {
    std::int32_t row = 0;       ///< in the sample table
    const Hit* hit = nullptr;
    const SurfacePoint* point = nullptr;
    const SurfaceSource* source = nullptr;
    const Bsdf* bsdf = nullptr;
};

/// Appends a hit to `batch`, whose room was made with batch.resize(capacity, aovs.inputs()) and whose count is then set
/// to 0. Only the columns that the render's AOVs read are filled.
void add_first_hit(const IntegratorContext& context, const FirstHit& first, geoaovs::ShadingBatch& batch);

/// How far `position` lies from the nearest of the edges (start and end by turns), in pixels of the image; infinity when
/// there is none. Edges that pass behind the camera are cut.
float edge_distance(const IntegratorContext& context, const Vec3& position, std::span<const Vec3> edges);

}  // namespace raylex::transport
