// Maps the unit sphere to the unit square with equal areas: P. Clarberg 2008, "Fast Equal-Area Mapping of the
// (Hemi)Sphere using SIMD", the layout of pbrt-v4's environment images.
#pragma once

#include "transport/math/vec.h"

namespace raylex::transport {

/// Unit direction to the unit square and back; the square's (0, 0) is the image's top left corner.
Vec2 octahedral_from_direction(const Vec3& direction);
Vec3 direction_from_octahedral(const Vec2& uv);

}  // namespace raylex::transport
