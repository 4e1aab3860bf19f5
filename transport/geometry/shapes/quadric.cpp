#include "transport/geometry/shapes/quadric.h"

#include <algorithm>
#include <numbers>

#include "display/services/elementary.h"

namespace raylex::transport {
namespace {

constexpr double two_pi = 2 * std::numbers::pi;

double angle_of(const DVec3& p) {
    const double phi = elementary::atan2(p.y, p.x);
    return phi < 0 ? phi + two_pi : phi;
}

}  // namespace

Quadric::Quadric(const SceneShape& shape, const Transform& to_world) : kind(shape.kind), placement(to_world) {
    radius = shape.radius;
    phi_max = std::clamp(static_cast<double>(shape.phi_max), 0.0, 360.0) * (std::numbers::pi / 180);
    partial = shape.phi_max < 360;
    height = shape.height;
    inner_radius = shape.inner_radius;
    z_min = std::min(shape.z_min, shape.z_max);
    z_max = std::max(shape.z_min, shape.z_max);
    if (kind == ShapeKind::sphere) {
        partial = partial || z_min > -radius || z_max < radius;
        z_min = std::clamp(z_min, -radius, radius);
        z_max = std::clamp(z_max, -radius, radius);
        theta_min = elementary::acos(z_min / radius);
        theta_max = elementary::acos(z_max / radius);
    }
    // flip_normal is ReverseOrientation xor handedness. The inverse transpose that transforms normals keeps the outside
    // outside, so only ReverseOrientation remains to be applied.
    reversed = shape.flip_normal != to_world.swaps_handedness();
}

bool Quadric::accept(const DVec3& p, double& u, double& v) const {
    const double phi = angle_of(p);
    if (kind == ShapeKind::sphere) {
        const double theta = elementary::acos(std::clamp(p.z / radius, -1.0, 1.0));
        if (partial && ((z_min > -radius && p.z < z_min) || (z_max < radius && p.z > z_max) || phi > phi_max))
            return false;
        v = (theta - theta_min) / (theta_max - theta_min);
    } else if (kind == ShapeKind::cylinder) {
        if (p.z < z_min || p.z > z_max || phi > phi_max) return false;
        v = (p.z - z_min) / (z_max - z_min);
    } else {
        const double r = elementary::hypot(p.x, p.y);
        if (r > radius || r < inner_radius || phi > phi_max) return false;
        v = (radius - r) / (radius - inner_radius);
    }
    u = phi / phi_max;
    return true;
}

bool Quadric::intersect(const DVec3& origin, const DVec3& direction, double t_min, double t_max, double& t, double& u,
                        double& v) const {
    const DVec3 o = placement.to_object.point(origin), d = placement.to_object.vector(direction);
    if (kind == ShapeKind::disk) {
        if (d.z == 0) return false;
        t = (height - o.z) / d.z;
        return t > t_min && t < t_max && accept({o.x + t * d.x, o.y + t * d.y, height}, u, v);
    }
    const bool sphere = kind == ShapeKind::sphere;
    const DVec3 oq = sphere ? o : DVec3{o.x, o.y, 0}, dq = sphere ? d : DVec3{d.x, d.y, 0};
    const double a = dot(dq, dq);
    if (!(a > 0)) return false;
    // Discriminant from the point of closest approach: no cancellation for distant origins (Haines et al. 2019,
    // "Precision Improvements for Ray/Sphere Intersection", Ray Tracing Gems 7).
    const double b = -dot(oq, dq);
    const DVec3 closest = oq + dq * (b / a);
    const double discriminant = radius * radius - dot(closest, closest);
    if (discriminant < 0) return false;
    const double q = b + std::copysign(std::sqrt(a * discriminant), b);
    const double c = (length(oq) - radius) * (length(oq) + radius);
    double t0 = q == 0 ? 0 : c / q, t1 = q / a;
    if (t0 > t1) std::swap(t0, t1);
    for (const double root : {t0, t1}) {
        if (!(root > t_min && root < t_max)) continue;
        DVec3 p = o + d * root;
        const double r = sphere ? length(p) : elementary::hypot(p.x, p.y);
        const double scale = radius / r;
        p = sphere ? p * scale : DVec3{p.x * scale, p.y * scale, p.z};
        if (accept(p, u, v)) {
            t = root;
            return true;
        }
    }
    return false;
}

DVec3 Quadric::object_point(double u, double v) const {
    const auto [s, c] = elementary::sin_cos(u * phi_max);
    if (kind == ShapeKind::sphere) {
        const auto [sine, cosine] = elementary::sin_cos(theta_min + v * (theta_max - theta_min));
        return {radius * sine * c, radius * sine * s, radius * cosine};
    }
    if (kind == ShapeKind::cylinder) return {radius * c, radius * s, z_min + v * (z_max - z_min)};
    const double r = radius - v * (radius - inner_radius);
    return {r * c, r * s, height};
}

DVec3 Quadric::object_normal(const DVec3& p) const {
    if (kind == ShapeKind::sphere) return p * (1 / radius);
    if (kind == ShapeKind::cylinder) return DVec3{p.x, p.y, 0} * (1 / radius);
    return {0, 0, 1};
}

DVec3 Quadric::object_dpdv(const DVec3& p) const {
    if (kind == ShapeKind::cylinder) return {0, 0, z_max - z_min};
    const double rho = elementary::hypot(p.x, p.y), c = rho > 0 ? p.x / rho : 1, s = rho > 0 ? p.y / rho : 0;
    if (kind == ShapeKind::sphere) return DVec3{p.z * c, p.z * s, -rho} * (theta_max - theta_min);
    return DVec3{c, s, 0} * (inner_radius - radius);
}

double Quadric::object_area() const {
    if (kind == ShapeKind::disk) return phi_max * 0.5 * (radius * radius - inner_radius * inner_radius);
    return phi_max * radius * (z_max - z_min);  // Archimedes: a zone of the sphere has the area of its cylinder
}

void Quadric::sample_area(double a, double b, double& u, double& v) const {
    u = a;
    if (kind == ShapeKind::sphere) {
        const double z = z_min + b * (z_max - z_min);
        v = (elementary::acos(std::clamp(z / radius, -1.0, 1.0)) - theta_min) / (theta_max - theta_min);
    } else if (kind == ShapeKind::cylinder) {
        v = b;
    } else {
        const double r = std::sqrt(inner_radius * inner_radius + b * (radius * radius - inner_radius * inner_radius));
        v = (radius - r) / (radius - inner_radius);
    }
}

void Quadric::area_numbers(double u, double v, double& a, double& b) const {
    a = u;
    b = v;
    if (kind == ShapeKind::sphere) {
        const double z = radius * elementary::sin_cos(theta_min + v * (theta_max - theta_min)).cos;
        b = z_max > z_min ? (z - z_min) / (z_max - z_min) : 0;
    } else if (kind == ShapeKind::disk) {
        const double r = radius - v * (radius - inner_radius), inner = inner_radius * inner_radius;
        b = radius > inner_radius ? (r * r - inner) / (radius * radius - inner) : 0;
    }
}

Quadric::Point Quadric::world_point(double u, double v) const {
    const DVec3 p = object_point(u, v);
    const DVec3 n = placement.to_object.normal_of_inverse(object_normal(p));
    const double l = length(n);
    // dA_world = |det M| |M^-T n| dA_object.
    return {placement.to_world.point(p), n * ((reversed ? -1 : 1) / l), std::abs(placement.to_world.determinant()) * l};
}

void Quadric::bounds(DVec3& lower, DVec3& upper) const {
    const double z0 = kind == ShapeKind::disk ? height : z_min, z1 = kind == ShapeKind::disk ? height : z_max;
    lower = {1e300, 1e300, 1e300};
    upper = {-1e300, -1e300, -1e300};
    for (int corner = 0; corner < 8; ++corner) {
        const DVec3 p = placement.to_world.point(
            {corner & 1 ? radius : -radius, corner & 2 ? radius : -radius, corner & 4 ? z1 : z0});
        lower = {std::min(lower.x, p.x), std::min(lower.y, p.y), std::min(lower.z, p.z)};
        upper = {std::max(upper.x, p.x), std::max(upper.y, p.y), std::max(upper.z, p.z)};
    }
}

double Quadric::extent() const {
    DVec3 lower, upper;
    bounds(lower, upper);
    double largest = 0;
    for (const double v : {lower.x, lower.y, lower.z, upper.x, upper.y, upper.z})
        largest = std::max(largest, std::abs(v));
    return largest;
}

}  // namespace raylex::transport
