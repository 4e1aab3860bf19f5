// Bilinear patches in double: P(u, v) interpolates p00, p10, p01, p11 (pbrt-v4's order), planar or not.
#pragma once

#include "transport/math/matrix34.h"

namespace raylex::transport {

struct BilinearPatch {
    DVec3 p00, p10, p01, p11;

    [[nodiscard]] DVec3 point(double u, double v) const {
        return (p00 * (1 - v) + p01 * v) * (1 - u) + (p10 * (1 - v) + p11 * v) * u;
    }
    [[nodiscard]] DVec3 dpdu(double v) const { return (p10 - p00) * (1 - v) + (p11 - p01) * v; }
    [[nodiscard]] DVec3 dpdv(double u) const { return (p01 - p00) * (1 - u) + (p11 - p10) * u; }

    /// Finds the smallest t in (t_min, t_max); returns false if there is no hit.
    bool intersect(const DVec3& origin, const DVec3& direction, double t_min, double t_max, double& t, double& u,
                   double& v) const;
    /// The sum of the largest absolute coordinates.
    [[nodiscard]] double extent() const;
    [[nodiscard]] double area() const;  ///< by quadrature unless planar and a parallelogram
};

}  // namespace raylex::transport
