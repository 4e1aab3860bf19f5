// The plain structure of arrays that geometric AOVs are computed from: first hits of a batch of camera rays.
//
// transport/ fills it, geoaovs/ reads it; neither sees the other's types. Everything is in world space; `world_to_camera`
// takes it to camera space (x right, y up, +z forward).
#pragma once

#include <cstdint>
#include <vector>

namespace raylex::geoaovs {

struct ShadingBatch {
    int count = 0;                                   ///< hits in this batch; every array holds `count` entries
    std::vector<std::int32_t> row;                   ///< sample table row of each hit
    std::vector<float> position[3];                  ///< hit point, world
    std::vector<float> shading_normal[3];            ///< unit, world, facing the camera side of the ray
    std::vector<float> geometric_normal[3];          ///< unit, world, facing the camera side of the ray
    std::vector<float> s, t;                         ///< surface parameterisation, texture coordinates
    std::vector<float> distance;                     ///< along the ray from its origin, world units
    std::vector<std::int32_t> object_id;             ///< 1-based index of the object, 0 = none
    std::vector<float> albedo[3];                    ///< directional-hemispherical reflectance (+ transmittance) estimate
    float world_to_camera[3][4] = {};                ///< rigid part of the camera's inverse transform

    void resize(int hits);
};

}  // namespace raylex::geoaovs
