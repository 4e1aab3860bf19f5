// The albedo of GGX facets in double precision, independent of the closures: the reference of furnace tests.
#pragma once

#include <cmath>

#include "tests/stability/probes/draws.h"

namespace raylex::experiments {

struct ReferenceFacets {
    double alpha_x, alpha_y;
    double eta = 0;  ///< of glass: far side relative to wo's side; 0: metal that reflects everything

    /// Returns the directional albedo at `wo` (z > 0): reflected light, and for glass transmitted basic radiance.
    /// Integrates over slopes, which for GGX have the density P22 = 1 / (pi ax ay (1 + r^2)^2) with r^2 = (p/ax)^2 +
    /// (q/ay)^2 (Heitz 2014, equations 11, 72, 99), so s = r^2 / (1 + r^2) and the angle are uniform. Midpoint rule
    /// with n x n points.
    [[nodiscard]] double albedo(const transport::BasicVec3<double>& wo, int n) const {
        double sum = 0;
        for (int i = 0; i < n; ++i) {
            const double t = (i + 0.5) / n, left = (1 - t) * (1 - t), r = std::sqrt((1 - left) / left);
            for (int j = 0; j < n; ++j) {
                const double phi = 2 * exact_pi * (j + 0.5) / n;
                const DVec3 m = unit({alpha_x * r * std::cos(phi), alpha_y * r * std::sin(phi), 1});
                const double om = dot_of(wo, m);
                if (om > 0) sum += 2 * (1 - t) * om / (wo.z * m.z) * given_back(wo, m, om);
            }
        }
        return sum / (double(n) * n);
    }

  private:
    using DVec3 = transport::BasicVec3<double>;

    static double dot_of(const DVec3& a, const DVec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
    static DVec3 unit(const DVec3& v) { return v * (1 / std::sqrt(dot_of(v, v))); }
    [[nodiscard]] double lambda(const DVec3& w) const {
        const double x = alpha_x * w.x / w.z, y = alpha_y * w.y / w.z;
        return (std::sqrt(1 + x * x + y * y) - 1) / 2;
    }
    [[nodiscard]] double given_back(const DVec3& wo, const DVec3& m, double om) const {
        const auto masked = [&](const DVec3& wi) { return wi.z > 0 ? 1 / (1 + lambda(wo) + lambda(wi)) : 0; };
        const double sin2_t = eta > 0 ? (1 - om * om) / (eta * eta) : 1;
        const double reflected = masked(m * (2 * om) - wo);
        if (sin2_t >= 1) return reflected;
        const double cos_t = std::sqrt(1 - sin2_t);
        const double parallel = (eta * om - cos_t) / (eta * om + cos_t),
                     across = (om - eta * cos_t) / (om + eta * cos_t);
        const double fresnel = (parallel * parallel + across * across) / 2;
        const DVec3 refracted = m * (om / eta - cos_t) - wo * (1 / eta);
        return fresnel * reflected + (1 - fresnel) * masked({refracted.x, refracted.y, -refracted.z});
    }
};

}  // namespace raylex::experiments
