// The structures of arrays from which geometric AOVs are computed: first hits of a batch of camera rays, and the rays
// themselves.
//
// transport/ fills them, and geoaovs/ reads them; neither uses the other's types. Unless noted otherwise everything is
// in render space, with the world's axes and unit and an origin near the visible scene, so that floats are precise
// enough. `world_to_camera` transforms render space to camera space (x right, y up, +z forward); adding `origin` in
// double gives world space.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace raylex::geoaovs {

/// A mask of columns. A renderer fills the columns that the requested AOVs use, and leaves the others empty.
using Inputs = std::uint32_t;
namespace inputs {
inline constexpr Inputs position = 1u << 0, shading_normal = 1u << 1, geometric_normal = 1u << 2,
                        plain_normal = 1u << 3, view = 1u << 4, texture = 1u << 5, parameters = 1u << 6, dpdu = 1u << 7,
                        dpdv = 1u << 8, object_position = 1u << 9, curvature = 1u << 10, outside_ior = 1u << 11,
                        ids = 1u << 12, edges = 1u << 13, albedo = 1u << 14;
inline constexpr Inputs all = (1u << 15) - 1;
}  // namespace inputs

struct ShadingBatch {
    int count = 0;                           ///< hits in this batch; every filled array has at least `count` elements
    std::vector<std::int32_t> row;           ///< sample table row of each hit
    std::vector<float> position[3];          ///< hit point
    std::vector<float> shading_normal[3];    ///< unit, on the side of the ray's origin; with bump mapping
    std::vector<float> geometric_normal[3];  ///< unit, on the side of the ray's origin
    std::vector<float> plain_normal[3];      ///< unit, on the side of the ray's origin; shading normal before bump and
                                             ///< normal maps
    std::vector<float> view[3];              ///< unit, from the hit towards the ray's origin
    std::vector<float> s, t;                 ///< texture coordinates
    std::vector<float> u, v;                 ///< parameters of the primitive
    std::vector<float> dpdu[3], dpdv[3];     ///< derivatives of the position by s and t
    std::vector<float> object_position[3];   ///< in the space in which the shape was defined
    std::vector<float> curvature;            ///< mean curvature, 1/length; positive: convex towards the viewer
    std::vector<float> outside_ior;          ///< refractive index on the side of the ray's origin
    std::vector<std::int32_t> object_id;     ///< 1-based number of the object, 0 = none
    std::vector<std::int32_t> part_id;       ///< 1-based number of the shape in an instance, 0 = not in one
    std::vector<std::int32_t> surface_id;    ///< 1-based number among all shapes of all instances
    std::vector<float> edge_pixels;          ///< distance to the primitive's nearest edge in pixels of the image; +inf:
                                             ///< none
    std::vector<float> albedo[3];            ///< directional-hemispherical reflectance (+ transmittance) estimate
    float world_to_camera[3][4] = {};        ///< rigid part of the camera's inverse transform, from render space
    double origin[3] = {};                   ///< of render space, in world space

    /// Makes room for `hits` hits in the columns of `wanted`; the other columns are unchanged.
    void resize(int hits, Inputs wanted = inputs::all);
};

/// The camera rays of a sample table, row by row, from which depths are computed.
struct RayBatch {
    std::vector<float> origin_z, direction_z;  ///< third components of origin and unit direction in camera space
};

}  // namespace raylex::geoaovs
