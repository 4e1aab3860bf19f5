// What a pixel sees of a surface, from ray cones (Akenine-Moeller et al. 2019, "Texture Level of Detail Strategies for
// Real-Time Ray Tracing"; 2021, "Improved Shader and Texture Level of Detail Using Ray Cones"): image textures are
// filtered over that. Only subpaths from the camera have cones that begin as wide as a pixel; elsewhere images are read
// as they are.
#pragma once

#include "transport/embree/embree_scene.h"
#include "transport/materials/closures/closure.h"

namespace raylex::transport {

/// How much of a pixel a sample stands for, as a length: each sample as if the image ended with it, since what several
/// samples see need not be blurred by one. At least an eighth. Depends on nothing but the sample's number (Law 3).
[[nodiscard]] Real pixel_share(std::uint64_t sample);
/// A camera ray's cone, which is as wide as a pixel, as wide as what a sample stands for.
[[nodiscard]] RayCone cone_of_sample(const RayCone& of_pixel, std::uint64_t sample);

/// Of a cone that is `width` wide at `point` and runs along -wo: seen at a slant it is longer, 100 times at most.
[[nodiscard]] SurfaceFootprint footprint_of(const SurfaceTangents& tangents, const SurfacePoint& point, Real width);

/// The cone of the ray that `sample` sends on, where a cone arrives as `cone`. A mirror or smooth glass turns and bends
/// it with the surface; else it is an eighth as wide as the share of directions that the sample stands for, at least.
[[nodiscard]] RayCone scattered_cone(const EmbreeScene& geometry, const Hit& hit, const SurfacePoint& point,
                                     const BsdfSample& sample);

}  // namespace raylex::transport
