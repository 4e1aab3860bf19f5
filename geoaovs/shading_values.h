// Values of AOVs that are not columns of a shading batch, as functions of the batch and an index; geoaovs.cpp's table
// uses them.
#pragma once

#include <algorithm>
#include <cmath>

#include "display/services/elementary.h"
#include "display/services/rgb.h"
#include "geoaovs/shading_batch.h"

namespace raylex::geoaovs::values {

using Hits = const ShadingBatch&;
using At = std::size_t;

inline Rgb triple(const std::vector<float> (&columns)[3], At i) {
    return {columns[0][i], columns[1][i], columns[2][i]};
}
inline float dot(const Rgb& a, const Rgb& b) {
    return a.r * b.r + a.g * b.g + a.b * b.b;
}
inline float length(const Rgb& v) {
    return std::sqrt(dot(v, v));
}

inline float camera_axis(Hits h, int axis, const Rgb& v) {
    const float* m = h.world_to_camera[axis];
    return m[0] * v.r + m[1] * v.g + m[2] * v.b;
}
/// The transform is rigid, so normals transform like vectors.
inline Rgb camera_vector(Hits h, const Rgb& v) {
    return {camera_axis(h, 0, v), camera_axis(h, 1, v), camera_axis(h, 2, v)};
}

/// Where the parameterisation degenerates (the pole of a sphere) the tangent is 0.
inline constexpr auto tangent = [](Hits h, At i) {
    const Rgb d = triple(h.dpdu, i);
    const float l = length(d);
    return l > 0 ? camera_vector(h, d * (1 / l)) : Rgb();
};

inline constexpr auto st = [](Hits h, At i) { return Rgb(h.s[i], h.t[i], 0.0f); };

/// Uses the arc tangent, which keeps its digits near 0, where the arc cosine loses half of them.
inline constexpr auto incidence_angle = [](Hits h, At i) {
    const Rgb n = triple(h.shading_normal, i), w = triple(h.view, i);
    const Rgb cross{n.g * w.b - n.b * w.g, n.b * w.r - n.r * w.b, n.r * w.g - n.g * w.r};
    return elementary::atan2(length(cross), std::abs(dot(n, w)));
};
/// A coordinate of the hit point in world space.
template <int axis>
inline constexpr auto world_coordinate =
    [](Hits h, At i) { return static_cast<float>(static_cast<double>(h.position[axis][i]) + h.origin[axis]); };
inline constexpr auto world_position = [](Hits h, At i) {
    return Rgb(world_coordinate<0>(h, i), world_coordinate<1>(h, i), world_coordinate<2>(h, i));
};

inline constexpr auto depth_height_facing = [](Hits h, At i) {
    const Rgb p = triple(h.position, i);
    return Rgb(camera_axis(h, 2, p) + h.world_to_camera[2][3], world_coordinate<1>(h, i),
               std::abs(dot(triple(h.shading_normal, i), triple(h.view, i))));
};

/// A line one pixel wide, half on either side of the edge; the pixel filter smooths it.
inline constexpr auto wireframe = [](Hits h, At i) { return h.edge_pixels[i] < 0.5f ? 1.0f : 0.0f; };

}  // namespace raylex::geoaovs::values
