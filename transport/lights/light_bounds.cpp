#include "transport/lights/light_bounds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "display/services/elementary.h"

namespace raylex::transport {
namespace {

Real sine_of(Real cosine) {
    return std::sqrt(std::max(Real(0), 1 - cosine * cosine));
}
/// cos(max(0, a - b)) and sin of it.
Real cos_of_difference(Real sin_a, Real cos_a, Real sin_b, Real cos_b) {
    return cos_a > cos_b ? 1 : cos_a * cos_b + sin_a * sin_b;
}
Real sin_of_difference(Real sin_a, Real cos_a, Real sin_b, Real cos_b) {
    return cos_a > cos_b ? 0 : sin_a * cos_b - cos_a * sin_b;
}
Real angle_of(Real cosine) {
    return elementary::atan2(sine_of(cosine), cosine);
}
Real angle_between(const Vec3& a, const Vec3& b) {
    return elementary::atan2(length(cross(a, b)), dot(a, b));
}

struct DirectionCone {
    Vec3 axis{0, 0, 1};
    Real cosine = -1;
};

DirectionCone join(const DirectionCone& a, const DirectionCone& b) {
    const Real theta_a = angle_of(a.cosine), theta_b = angle_of(b.cosine), apart = angle_between(a.axis, b.axis);
    if (std::min(apart + theta_b, pi) <= theta_a) return a;
    if (std::min(apart + theta_a, pi) <= theta_b) return b;
    const Real theta = (theta_a + apart + theta_b) / 2 + Real(1e-5);
    const Vec3 about = cross(a.axis, b.axis);
    if (theta >= pi || !(length_squared(about) > 0)) return {};
    const Vec3 sideways = cross(normalize(about), a.axis);
    const auto turn = elementary::sin_cos(theta - theta_a), half = elementary::sin_cos(theta);
    return {normalize(a.axis * turn.cos + sideways * turn.sin), half.cos};
}

void set_box(LightBounds& bounds, std::initializer_list<Vec3> points) {
    bounds.lower = bounds.upper = *points.begin();
    for (const Vec3& p : points) {
        bounds.lower = smallest(bounds.lower, p);
        bounds.upper = largest(bounds.upper, p);
    }
}

void set_patch(LightBounds& bounds, const BilinearPatch& patch) {
    set_box(bounds, {patch.p00.to_real(), patch.p10.to_real(), patch.p01.to_real(), patch.p11.to_real()});
    // The cross product is bilinear in (u, v): its corners bound it, where they lie within half a sphere.
    Vec3 sum;
    std::array<Vec3, 4> corners;
    for (int i = 0; i < 4; ++i) {
        const DVec3 n = cross(patch.dpdu(i / 2), patch.dpdv(i % 2));
        const double area = length(n);
        corners[static_cast<std::size_t>(i)] = area > 0 ? (n * (1 / area)).to_real() : Vec3();
        sum = sum + corners[static_cast<std::size_t>(i)];
    }
    if (!(length_squared(sum) > 0)) return;
    bounds.axis = normalize(sum);
    Real least = 1;
    for (const Vec3& corner : corners)
        if (length_squared(corner) > 0) least = std::min(least, dot(bounds.axis, corner));
    bounds.cos_theta_o = least > 0 ? least - Real(1e-5) : -1;
    bounds.two_sided = true;  // which side emits is not asked here
}

}  // namespace

LightBounds bounds_of(const Light& light, const EmbreeScene& geometry, Real relative_power) {
    LightBounds bounds;
    bounds.axis = {0, 0, 1};
    bounds.power = relative_power;
    bounds.cos_theta_e = Real(-1e-4);
    const ShapeGeometry* shape = light.is_area() ? &geometry.shapes()[light.shape] : nullptr;
    if (light.kind == LightKind::triangle) {
        set_box(bounds, {light.position, light.position + light.edge1, light.position + light.edge2});
        bounds.axis = light.direction;
        bounds.cos_theta_o = 1;
        bounds.two_sided = light.two_sided;
    } else if (light.kind == LightKind::patch) {
        set_patch(bounds, shape->patch(light.primitive));
    } else if (shape != nullptr) {
        DVec3 lower, upper;
        shape->quadric.bounds(lower, upper);
        bounds.lower = lower.to_real();
        bounds.upper = upper.to_real();
    } else {
        bounds.lower = bounds.upper = light.position;
        if (light.kind == LightKind::spot || light.kind == LightKind::projection) {
            bounds.axis = light.direction;
            bounds.cos_theta_o = 1 - light.versine_full;
            const Real beyond = angle_of(1 - light.versine_zero) - angle_of(bounds.cos_theta_o);
            bounds.cos_theta_e = elementary::sin_cos(std::max(beyond, Real(0)) + Real(1e-3)).cos;
        }
    }
    return bounds;
}

LightBounds join(const LightBounds& a, const LightBounds& b) {
    if (!(a.power > 0)) return b;
    if (!(b.power > 0)) return a;
    const DirectionCone cone = join(DirectionCone{a.axis, a.cos_theta_o}, DirectionCone{b.axis, b.cos_theta_o});
    return {smallest(a.lower, b.lower),
            largest(a.upper, b.upper),
            cone.axis,
            cone.cosine,
            std::min(a.cos_theta_e, b.cos_theta_e),
            a.power + b.power,
            a.two_sided || b.two_sided};
}

Real LightBounds::importance(const LightReceiver& receiver) const {
    const Vec3 center = (lower + upper) * Real(0.5), diagonal = upper - lower;
    const Vec3 way = receiver.position - center;
    const Real d2 = length_squared(way), radius2 = length_squared(diagonal) / 4;
    // Nearer than its own size a group is as near as its middle.
    const Real least = std::max({d2, std::sqrt(radius2), std::numeric_limits<Real>::min()});
    // Inside of the sphere around the box light may come from anywhere.
    if (!(d2 > radius2)) return power / least;
    const Vec3 wi = way / std::sqrt(d2);  // towards the receiver
    const Real sin2_b = radius2 / d2, sin_b = std::sqrt(sin2_b), cos_b = std::sqrt(1 - sin2_b);
    Real cos_w = dot(axis, wi);
    if (two_sided) cos_w = std::abs(cos_w);
    const Real sin_w = sine_of(cos_w), sin_o = sine_of(cos_theta_o);
    const Real cos_x = cos_of_difference(sin_w, cos_w, sin_o, cos_theta_o),
               sin_x = sin_of_difference(sin_w, cos_w, sin_o, cos_theta_o);
    const Real cos_p = cos_of_difference(sin_x, cos_x, sin_b, cos_b);
    if (cos_p <= cos_theta_e) return 0;
    Real importance = power * std::max(cos_p, Real(1e-4)) / least;
    if (length_squared(receiver.normal) > 0) {
        const Real cos_i = abs_dot(wi, receiver.normal);
        importance *= std::max(cos_of_difference(sine_of(cos_i), cos_i, sin_b, cos_b), Real(1e-4));
    }
    return importance;
}

Real LightBounds::cost(const Vec3& whole, int split_axis) const {
    const Real theta_o = angle_of(cos_theta_o), theta_e = angle_of(cos_theta_e),
               theta_w = std::min(theta_o + theta_e, pi), sin_o = sine_of(cos_theta_o);
    const auto cosine = [](Real x) { return elementary::sin_cos(x).cos; };
    const Real solid =
        2 * pi * (1 - cos_theta_o) +
        pi / 2 * (2 * theta_w * sin_o - cosine(theta_o - 2 * theta_w) - 2 * theta_o * sin_o + cos_theta_o);
    const Vec3 d = upper - lower;
    const Real area = 2 * (d.x * d.y + d.y * d.z + d.z * d.x), longest = std::max({whole.x, whole.y, whole.z});
    const Real along = split_axis == 0 ? whole.x : split_axis == 1 ? whole.y : whole.z;
    // Lights of no extent in a row are still apart: half of the length stands for the area that they do not have.
    const Real spread = area + Real(1e-3) * length_squared(d);
    return power * solid * (longest / along) * spread;
}

}  // namespace raylex::transport
