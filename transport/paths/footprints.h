// The part of a surface over which image textures are filtered, from ray cones (Akenine-Moeller et al. 2019, "Texture
// Level of Detail Strategies for Real-Time Ray Tracing"; 2021, "Improved Shader and Texture Level of Detail Using Ray
// Cones"). Only subpaths from the camera have cones, which begin as wide as a pixel. Elsewhere images are not filtered.
#pragma once

#include "transport/embree/embree_scene.h"
#include "transport/materials/closures/closure.h"

namespace raylex::transport {

/// The width of the part of a pixel for which a sample stands, at least an eighth. Samples average what they see, so
/// each may be narrower: sample n as if the pixel had n samples. Depends on the sample's number alone (Law 3).
[[nodiscard]] Real pixel_share(std::uint64_t sample);
/// Narrows the cone of a camera ray from a pixel to the part for which a sample stands.
[[nodiscard]] RayCone cone_of_sample(const RayCone& of_pixel, std::uint64_t sample);

/// The footprint of a cone of width `width` at `point` along -wo. At a slant it is longer, at most 100 times.
[[nodiscard]] SurfaceFootprint footprint_of(const SurfaceTangents& tangents, const SurfacePoint& point, Real width);

/// The cone of the ray that leaves a hit by `sample`. Mirrors and smooth glass turn and bend the arriving cone with the
/// surface. Otherwise it is at least an eighth as wide as the part of directions for which the sample stands.
[[nodiscard]] RayCone scattered_cone(const EmbreeScene& geometry, const Hit& hit, const SurfacePoint& point,
                                     const BsdfSample& sample);

}  // namespace raylex::transport
