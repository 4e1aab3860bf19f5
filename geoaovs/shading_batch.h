// The plain structures of arrays that geometric AOVs are computed from: first hits of a batch of camera rays, and the
// rays themselves.
//
// transport/ fills them, geoaovs/ reads them; neither sees the other's types. Unless it says otherwise everything is in
// render space: the world's axes and unit, the origin near what is seen, so that floats hold it. `world_to_camera`
// takes that to camera space (x right, y up, +z forward), `origin` added in double to the world's.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace raylex::geoaovs {

/// The columns that an AOV reads. A renderer fills what the AOVs asked for need and leaves the rest empty.
using Inputs = std::uint32_t;
namespace inputs {
inline constexpr Inputs position = 1u << 0, shading_normal = 1u << 1, geometric_normal = 1u << 2,
                        plain_normal = 1u << 3, view = 1u << 4, texture = 1u << 5, parameters = 1u << 6, dpdu = 1u << 7,
                        dpdv = 1u << 8, object_position = 1u << 9, curvature = 1u << 10, outside_ior = 1u << 11,
                        ids = 1u << 12, edges = 1u << 13, albedo = 1u << 14;
inline constexpr Inputs all = (1u << 15) - 1;
}  // namespace inputs

struct ShadingBatch {
    int count = 0;                           ///< hits in this batch; every filled array holds at least `count`
    std::vector<std::int32_t> row;           ///< sample table row of each hit
    std::vector<float> position[3];          ///< hit point
    std::vector<float> shading_normal[3];    ///< unit, facing the side the ray came from; with bumps, if any
    std::vector<float> geometric_normal[3];  ///< unit, facing the side the ray came from
    std::vector<float> plain_normal[3];      ///< shading normal before bump and normal maps, likewise
    std::vector<float> view[3];              ///< unit, from the hit towards where the ray came from
    std::vector<float> s, t;                 ///< texture coordinates
    std::vector<float> u, v;                 ///< the primitive's own parameters
    std::vector<float> dpdu[3], dpdv[3];     ///< derivatives of the position by s and t
    std::vector<float> object_position[3];   ///< in the space that the shape was defined in
    std::vector<float> curvature;            ///< mean curvature, 1/length; positive: bulges towards the viewer
    std::vector<float> outside_ior;          ///< refractive index on the side the ray came from
    std::vector<std::int32_t> object_id;     ///< 1-based number of the object, 0 = none
    std::vector<std::int32_t> part_id;       ///< 1-based number of the shape in an instance, 0 = not in one
    std::vector<std::int32_t> surface_id;    ///< 1-based number among all shapes of all instances
    std::vector<float> edge_pixels;          ///< to the primitive's nearest edge, pixels of the image; +inf: none
    std::vector<float> albedo[3];            ///< directional-hemispherical reflectance (+ transmittance) estimate
    float world_to_camera[3][4] = {};        ///< rigid part of the camera's inverse transform, from render space
    double origin[3] = {};                   ///< of render space, in the world

    /// Room for `hits` hits in the columns of `wanted`; the others stay as they are.
    void resize(int hits, Inputs wanted = inputs::all);
};

/// What depths are computed from: the camera rays of a sample table, row by row.
struct RayBatch {
    std::vector<float> origin_z, direction_z;  ///< third components of origin and unit direction, camera space
};

}  // namespace raylex::geoaovs
