// A point of a surface for scattering and lights: the geometric result of a hit.
#pragma once

#include <cmath>
#include <cstdint>

#include "transport/math/vec.h"

namespace raylex::display {
class DisplayServices;
}

namespace raylex::transport {

/// The display services of the camera path of which the point is a vertex. Materials and patterns write to them.
struct VertexServices {
    display::DisplayServices* display = nullptr;  ///< null: nothing can be written (light paths, light samples, pilots)
    std::int32_t row = -1;    ///< of the sample table, for every call of the services; -1 without them
    std::uint32_t depth = 0;  ///< scattering events between the camera and this point

    /// Whether the camera sees the point directly, with nothing but cutouts and media in between.
    [[nodiscard]] bool camera_sees() const { return display != nullptr && depth == 0; }
};

/// The footprint of a pixel on a surface around a point: the sides of a parallelogram, in the world and in texture
/// coordinates.
struct SurfaceFootprint {
    Vec3 first, second;
    Vec2 first_uv, second_uv;
};

/// The geometric data of a hit; materials turn a batch of these into closures.
struct SurfacePoint {
    Vec3 position, geometric_normal, shading_normal;  ///< world; normals unit; geometric normal on the shape's outside
    Vec3 dpdu;
    Vec3 wo;  ///< unit, away from the surface, towards where the path came from
    Real u = 0, v = 0;
    bool mirrored = false;  ///< for curves: the transform to the world swaps handedness, so v runs the other way across
    static constexpr std::int32_t no_material = -1;  ///< a point in a medium: no surface, the normals are zero
    std::int32_t material = 0;
    std::uint32_t random_key = 0;                 ///< counter-based key for stochastic closures and `mix`
    const SurfaceFootprint* footprint = nullptr;  ///< null: textures are not filtered
    std::uint32_t direction_region = 0;           ///< set by DirectionSampler::locate(); 0: unknown
    VertexServices services;

    /// |cos| between a direction and the surface; 1 in a medium.
    [[nodiscard]] Real cosine(const Vec3& direction) const {
        return material == no_material ? 1.0f : std::abs(dot(geometric_normal, direction));
    }
};

/// The change of a surface and its shading normal with the texture coordinates, for bump and normal maps. World space,
/// around SurfacePoint::shading_normal. Vertex normals turn the tangents as in pbrt-v4.
struct SurfaceTangents {
    Vec3 dpdu, dpdv, dndu, dndv;
};

}  // namespace raylex::transport
