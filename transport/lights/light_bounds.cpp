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
/// The cosine and sine of max(0, a - b).
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
    if (a.cosine <= -1) return a;
    if (b.cosine <= -1) return b;
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

/// Whether the light is a cone with known angles: a stretched spot has only a known axis in the world.
bool is_cone(const Light& light) {
    return (light.kind == LightKind::spot && light.image < 0) || light.kind == LightKind::projection;
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
    // The cross product is bilinear in (u, v), so its corners bound it if they lie within half a sphere.
    Vec3 sum;
    std::array<Vec3, 4> corners;
    for (int i = 0; i < 4; ++i) {
        const DVec3 n = cross(patch.dpdu(i / 2), patch.dpdv(i % 2));
        const double area = length(n);
        corners[static_cast<std::size_t>(i)] = area > 0 ? (n * (1 / area)).to_real() : Vec3();
        sum = sum + corners[static_cast<std::size_t>(i)];
    }
    if (!(length_squared(sum) > 0)) return;
    EmissionCone& cone = bounds.cone;
    cone.axis = normalize(sum);
    Real least = 1;
    for (const Vec3& corner : corners)
        if (length_squared(corner) > 0) least = std::min(least, dot(cone.axis, corner));
    cone.cos_theta_o = least > 0 ? least - Real(1e-5) : -1;
    cone.two_sided = true;  // the emitting side is not stored here
}

}  // namespace

LightBounds bounds_of(const Light& light, const EmbreeScene& geometry, Real relative_power) {
    LightBounds bounds;
    EmissionCone& cone = bounds.cone;
    bounds.power = relative_power;
    cone.cos_theta_e = Real(-1e-4);
    const ShapeGeometry* shape = light.is_area() ? &geometry.shapes()[light.shape] : nullptr;
    if (light.kind == LightKind::triangle) {
        set_box(bounds, {light.position, light.position + light.edge1, light.position + light.edge2});
        cone.axis = light.direction;
        cone.cos_theta_o = 1;
        cone.two_sided = light.two_sided;
    } else if (light.kind == LightKind::patch) {
        set_patch(bounds, shape->patch(light.primitive));
    } else if (shape != nullptr) {
        DVec3 lower, upper;
        shape->quadric.bounds(lower, upper);
        bounds.lower = lower.to_real();
        bounds.upper = upper.to_real();
    } else {
        bounds.lower = bounds.upper = light.position;
        if (is_cone(light)) {
            cone.axis = light.direction;
            cone.cos_theta_o = 1 - light.versine_full;
            const Real beyond = angle_of(1 - light.versine_zero) - angle_of(cone.cos_theta_o);
            cone.cos_theta_e = elementary::sin_cos(std::max(beyond, Real(0)) + Real(1e-3)).cos;
        }
    }
    return bounds;
}

LightBounds join(const LightBounds& a, const LightBounds& b) {
    if (!(a.power > 0)) return b;
    if (!(b.power > 0)) return a;
    const DirectionCone cone =
        join(DirectionCone{a.cone.axis, a.cone.cos_theta_o}, DirectionCone{b.cone.axis, b.cone.cos_theta_o});
    return {smallest(a.lower, b.lower),
            largest(a.upper, b.upper),
            {cone.axis, cone.cosine, std::min(a.cone.cos_theta_e, b.cone.cos_theta_e),
             a.cone.two_sided || b.cone.two_sided},
            a.power + b.power};
}

LightMoments moments_of(const Light& light, const LightBounds& bounds) {
    LightMoments moments;
    moments.mean = (bounds.lower + bounds.upper) * Real(0.5);
    moments.spread = length_squared(bounds.upper - bounds.lower) / 12;  // a sphere's surface: its radius squared
    moments.strength = bounds.power / pi;
    moments.squares = {Real(0.25), Real(0.25), Real(0.25), 0, 0, 0};
    if (light.kind == LightKind::triangle) {
        const Vec3 first = light.position + light.edge1, second = light.position + light.edge2;
        moments.mean = (light.position + first + second) / 3;
        moments.spread = (length_squared(light.position - moments.mean) + length_squared(first - moments.mean) +
                          length_squared(second - moments.mean)) /
                         12;
    } else if (is_cone(light)) {
        // The light that a cosine would spread over half a sphere is within the cone.
        moments.strength /= std::max(light.versine_full + light.versine_zero, std::numeric_limits<Real>::min());
    } else if (bounds.cone.cos_theta_o == -1) {
        return moments;
    }
    const Vec3& n = bounds.cone.axis;
    moments.squares = {n.x * n.x, n.y * n.y, n.z * n.z, n.x * n.y, n.x * n.z, n.y * n.z};
    if (!bounds.cone.two_sided) moments.facing = n;
    return moments;
}

LightMoments join(const LightMoments& a, const LightMoments& b) {
    LightMoments both;
    both.strength = a.strength + b.strength;
    const Real of_b = b.strength / both.strength, of_a = 1 - of_b;
    both.mean = a.mean * of_a + b.mean * of_b;
    both.spread = a.spread * of_a + b.spread * of_b + length_squared(a.mean - b.mean) * of_a * of_b;
    for (std::size_t i = 0; i < both.squares.size(); ++i) both.squares[i] = a.squares[i] * of_a + b.squares[i] * of_b;
    both.facing = a.facing * of_a + b.facing * of_b;
    return both;
}

/// Approximates the mean of |n . w| by the root of the mean of its square. 1 / distance^2 is taken at a quarter of the
/// lights' spread beyond the middle, and the directions from the lights as spread evenly around the direction from
/// there.
double LightMoments::importance(const LightReceiver& receiver) const {
    constexpr Real least_cosine = Real(0.01);  // keeps a minimum, since the mean may underestimate
    const Vec3 way = receiver.position - mean;
    const Real around = spread / 3, inverse = 1 / (length_squared(way) + spread / 4 + std::numeric_limits<Real>::min());
    const auto& [xx, yy, zz, xy, xz, yz] = squares;
    const Real squared = xx * way.x * way.x + yy * way.y * way.y + zz * way.z * way.z +
                         2 * (xy * way.x * way.y + xz * way.x * way.z + yz * way.y * way.z) + around * (xx + yy + zz);
    const Real leaving = (std::sqrt(squared * inverse) + dot(facing, way) * std::sqrt(inverse)) / 2;
    Real cosines = std::max(leaving, least_cosine);
    if (length_squared(receiver.normal) > 0) {
        const Real across = dot(way, receiver.normal);
        cosines *= std::max(std::sqrt((across * across + around) * inverse), least_cosine);
    }
    return double{strength} * double{cosines} * double{inverse};
}

bool EmissionCone::reaches(const Vec3& way, Real radius2) const {
    const Real d2 = length_squared(way);
    if (!(d2 > radius2)) return true;  // within the ball, light may come from anywhere
    const Real sin2_b = radius2 / d2, sin_b = std::sqrt(sin2_b), cos_b = std::sqrt(1 - sin2_b);
    Real cos_w = dot(axis, way) / std::sqrt(d2);
    if (two_sided) cos_w = std::abs(cos_w);
    const Real sin_w = sine_of(cos_w), sin_o = sine_of(cos_theta_o);
    const Real cos_x = cos_of_difference(sin_w, cos_w, sin_o, cos_theta_o),
               sin_x = sin_of_difference(sin_w, cos_w, sin_o, cos_theta_o);
    return cos_of_difference(sin_x, cos_x, sin_b, cos_b) > cos_theta_e;
}

Real LightBounds::radius_squared(const Vec3& center) const {
    const Vec3 reach = largest(upper - center, center - lower);
    return length_squared(reach) * (1 + Real(1e-5));
}

Real LightBounds::cost(const Vec3& whole, int split_axis) const {
    const Real cos_theta_o = cone.cos_theta_o, theta_o = angle_of(cos_theta_o), theta_e = angle_of(cone.cos_theta_e),
               theta_w = std::min(theta_o + theta_e, pi), sin_o = sine_of(cos_theta_o);
    const auto cosine = [](Real x) { return elementary::sin_cos(x).cos; };
    const Real solid =
        2 * pi * (1 - cos_theta_o) +
        pi / 2 * (2 * theta_w * sin_o - cosine(theta_o - 2 * theta_w) - 2 * theta_o * sin_o + cos_theta_o);
    const Vec3 d = upper - lower;
    const Real area = 2 * (d.x * d.y + d.y * d.z + d.z * d.x), longest = std::max({whole.x, whole.y, whole.z});
    const Real along = split_axis == 0 ? whole.x : split_axis == 1 ? whole.y : whole.z;
    // Lights without extent in a row have a distance but no area: use half of the length instead.
    const Real spread = area + Real(1e-3) * length_squared(d);
    return power * solid * (longest / along) * spread;
}

}  // namespace raylex::transport
