#include "transport/geometry/shapes/bilinear.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace raylex::transport {

// A ray meets the patch if, for some u, it meets the straight line between the points at u of two edges. That is a
// quadratic in u; v and t follow from the two lines (Reshetov 2019, "Cool Patches", Ray Tracing Gems 8).
bool BilinearPatch::intersect(const DVec3& o, const DVec3& d, double t_min, double t_max, double& t, double& u,
                              double& v) const {
    const DVec3 e10 = p10 - p00, left = p01 - p00, right = p11 - p10;
    const double a = dot(p00 - o, cross(d, left));
    const double end = dot(p10 - o, cross(d, right));
    const double c = dot(e10, cross(d, right - left));
    const double b = end - a - c;  // a + b u + c u^2 = 0
    double roots[2];
    int count = 0;
    // Planar trapezoids and parallelograms leave rounding noise in c, which moves u by 1e-14 where c is 1e-14 of the
    // others.
    if (std::abs(c) <= 1e-14 * (std::abs(a) + std::abs(end))) {
        if (b == 0) return false;
        roots[count++] = -a / b;
    } else {
        const double discriminant = b * b - 4 * a * c;
        if (discriminant < 0) return false;
        const double q = -0.5 * (b + std::copysign(std::sqrt(discriminant), b));
        roots[count++] = q / c;
        if (q != 0) roots[count++] = a / q;
    }
    double nearest = t_max;
    bool found = false;
    // Neighbouring patches share an edge: hits slightly beyond it are accepted so that no ray passes between them.
    constexpr double slack = 1e-12;
    for (int i = 0; i < count; ++i) {
        const double root = roots[i];
        if (!(root >= -slack && root <= 1 + slack)) continue;
        const DVec3 start = p00 + e10 * root, along = (p01 + (p11 - p01) * root) - start;
        const DVec3 delta = start - o, perpendicular = cross(d, along);
        const double p2 = dot(perpendicular, perpendicular);
        if (!(p2 > 0)) continue;
        const double hit_t = dot(cross(delta, along), perpendicular) / p2;
        const double hit_v = dot(cross(delta, d), perpendicular) / p2;
        if (!(hit_t > t_min && hit_t < nearest && hit_v >= -slack && hit_v <= 1 + slack)) continue;
        nearest = hit_t;
        t = hit_t;
        u = std::clamp(root, 0.0, 1.0);
        v = std::clamp(hit_v, 0.0, 1.0);
        found = true;
    }
    return found;
}

double BilinearPatch::extent() const {
    const auto largest = [&](double DVec3::*axis) {
        return std::max({std::abs(p00.*axis), std::abs(p10.*axis), std::abs(p01.*axis), std::abs(p11.*axis)});
    };
    return largest(&DVec3::x) + largest(&DVec3::y) + largest(&DVec3::z);
}

double BilinearPatch::area() const {
    // 16 x 16 midpoints: exact for parallelograms. For other patches the area is only a selection weight.
    double sum = 0;
    for (int j = 0; j < 16; ++j)
        for (int i = 0; i < 16; ++i) sum += length(cross(dpdu((j + 0.5) / 16), dpdv((i + 0.5) / 16)));
    return sum / 256;
}

}  // namespace raylex::transport
