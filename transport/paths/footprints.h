// The part of a surface over which image textures are filtered, from ray cones (Akenine-Moeller et al. 2019, "Texture
// Level of Detail Strategies for Real-Time Ray Tracing"; 2021, "Improved Shader and Texture Level of Detail Using Ray
// Cones"). Only subpaths from the camera have cones, which begin as wide as a pixel. Elsewhere images are not filtered.
#pragma once

#include "transport/embree/embree_scene.h"
#include "transport/materials/closures/closure.h"

namespace raylex::transport {

/// The width of the part of a pixel that a sample represents, relative to the pixel. Sample n represents a part as wide
/// as if the pixel had n + 1 samples, because the pixel averages its samples; at least 1/8. The width depends on the
/// sample's number alone (Law 3).
[[nodiscard]] Real pixel_share(std::uint64_t sample);
/// Narrows the cone of a camera ray from the width of a pixel to pixel_share(sample) of it.
[[nodiscard]] RayCone cone_of_sample(const RayCone& of_pixel, std::uint64_t sample);

/// The footprint at `point` of a cone that arrives along -wo with width `width`. At grazing angles it is longer, by a
/// factor of at most 100.
[[nodiscard]] SurfaceFootprint footprint_of(const SurfaceTangents& tangents, const SurfacePoint& point, Real width);

/// The cone of the ray that leaves a hit by `sample`. At mirrors and smooth glass it is the arriving cone, turned and
/// bent by the surface. Otherwise its angle is at least an eighth of that of a cone of 1 / pdf steradians.
[[nodiscard]] RayCone scattered_cone(const EmbreeScene& geometry, const Hit& hit, const SurfacePoint& point,
                                     const BsdfSample& sample);

}  // namespace raylex::transport
