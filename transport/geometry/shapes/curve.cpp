#include "transport/geometry/shapes/curve.h"

#include <algorithm>
#include <cmath>

namespace raylex::transport {
namespace {

DVec3 cubic(const DVec3 (&p)[4], double u) {
    const double v = 1 - u;
    return p[0] * (v * v * v) + p[1] * (3 * u * v * v) + p[2] * (3 * u * u * v) + p[3] * (u * u * u);
}

DVec3 cubic_derivative(const DVec3 (&p)[4], double u) {
    const double v = 1 - u;
    return ((p[1] - p[0]) * (v * v) + (p[2] - p[1]) * (2 * u * v) + (p[3] - p[2]) * (u * u)) * 3;
}

/// Newton's method for the two equations at the top of curve.h.
class CurveSolver {
  public:
    CurveSolver(const CurveSegment& segment, const DVec3& origin, const DVec3& direction)
        : segment_(segment), origin_(origin), direction_(direction), square_(dot(direction, direction)) {}

    /// The distance at which the ray meets the curve at u; `front`: where it enters a tube.
    [[nodiscard]] double distance_at(double u, bool front) const {
        const DVec3 to_curve = segment_.point(u) - origin_;
        if (segment_.type == CurveType::ribbon) {
            const DVec3 normal = segment_.normal(u);
            return dot(to_curve, normal) / dot(direction_, normal);
        }
        const double nearest = dot(to_curve, direction_) / square_;
        if (segment_.type == CurveType::flat) return nearest;
        const DVec3 aside = to_curve - direction_ * nearest;
        const double r = segment_.radius(u), inside = std::sqrt(std::max(r * r - dot(aside, aside), 0.0) / square_);
        return front ? nearest - inside : nearest + inside;
    }

    /// Returns whether the method converged.
    bool solve(double& u, double& t) const {
        for (int step = 0; step < 12; ++step) {
            const DVec3 c = segment_.point(u), d1 = segment_.derivative(u), d2 = segment_.second_derivative(u);
            const DVec3 q = origin_ + direction_ * t - c;
            const double along = dot(q, d1), along_u = dot(q, d2) - dot(d1, d1), along_t = dot(direction_, d1);
            const Row on = on_surface(u, q, d1);
            const double determinant = along_u * on.t - along_t * on.u;
            const double du = (on.value * along_t - along * on.t) / determinant,
                         dt = (along * on.u - on.value * along_u) / determinant;
            if (!std::isfinite(du) || !std::isfinite(dt)) return false;
            u += du;
            t += dt;
            if (!(std::abs(u - 0.5) < 1)) return false;
            // The error is about the square of the last step, so a step this small is the last one.
            if (std::abs(du) < 1e-9 && std::abs(dt) <= 1e-9 * std::abs(t)) return true;
        }
        return false;
    }

  private:
    /// The second equation and its derivatives.
    struct Row {
        double value, u, t;
    };
    [[nodiscard]] Row on_surface(double u, const DVec3& q, const DVec3& d1) const {
        if (segment_.type == CurveType::flat) return {dot(q, direction_), -dot(d1, direction_), square_};
        if (segment_.type == CurveType::ribbon) {
            const DVec3 n = segment_.normal(u);
            return {dot(q, n), dot(q, segment_.normal_derivative(u)) - dot(d1, n), dot(direction_, n)};
        }
        const double r = segment_.radius(u);
        return {0.5 * (dot(q, q) - r * r), -dot(q, d1) - r * (segment_.radius_end - segment_.radius_start),
                dot(q, direction_)};
    }

    const CurveSegment& segment_;
    const DVec3 &origin_, &direction_;
    double square_;
};

}  // namespace

DVec3 CurveSegment::point(double u) const {
    return cubic(points, u);
}

DVec3 CurveSegment::derivative(double u) const {
    return cubic_derivative(points, u);
}

DVec3 CurveSegment::second_derivative(double u) const {
    const DVec3 a = points[0] - points[1] * 2 + points[2], b = points[1] - points[2] * 2 + points[3];
    return (a * (1 - u) + b * u) * 6;
}

DVec3 CurveSegment::tangent(double u) const {
    const DVec3 d = derivative(u), chord = points[3] - points[0];
    // If three control points coincide, or two at an end, the derivative is 0 there: use the direction to the others.
    const double tiny = 1e-12 * (std::abs(chord.x) + std::abs(chord.y) + std::abs(chord.z));
    if (length(d) > tiny) return d;
    const DVec3 inwards = u < 0.5 ? points[2] - points[0] : points[3] - points[1];
    return length(inwards) > tiny ? inwards : length(chord) > 0 ? chord : DVec3{0, 0, 1};
}

DVec3 CurveSegment::normal(double u) const {
    return cubic(normals, u);
}

DVec3 CurveSegment::normal_derivative(double u) const {
    return cubic_derivative(normals, u);
}

CurveSegment CurveBatch::segment(std::uint32_t primitive) const {
    CurveSegment segment;
    segment.type = type;
    const std::size_t first = first_points[primitive / splits];
    for (std::size_t i = 0; i < 4; ++i) {
        const CurvePoint& p = points[first + i];
        segment.points[i] = {p.x, p.y, p.z};
        if (normals != nullptr) segment.normals[i] = DVec3(normals[first + i]);
    }
    segment.radius_start = static_cast<double>(points[first].radius);
    segment.radius_end = static_cast<double>(points[first + 3].radius);
    return segment;
}

bool meet_curve(const CurveSegment& segment, const DVec3& origin, const DVec3& direction, double t_max,
                CurvePlace& place) {
    const CurveSolver solver(segment, origin, direction);
    const DVec3 found = segment.point(place.u) - origin;
    const bool front = place.t * dot(direction, direction) <= dot(found, direction);
    double u = std::nearbyint(place.u * 4096) / 4096, t = solver.distance_at(u, front);
    if (!solver.solve(u, t)) return false;
    if (u < 0 || u > 1) {
        u = std::clamp(u, 0.0, 1.0);
        t = solver.distance_at(u, front);
    }
    const DVec3 p = origin + direction * t;
    const CurveFrame frame = curve_frame(segment, direction, u, 0, p);
    const double r = segment.radius(u), h = dot(p - segment.point(u), frame.across) / r;
    // Rejects points past the edge, on another bend, or on the other side of a tube than the hit. The pieces of a flat
    // curve are off by a tenth of r across, and more along rays that nearly follow it; Embree hits tubes exactly.
    const double off = std::abs(t - place.t) * length(direction);
    const bool there = std::abs(h) <= 1 + 1e-3 && t > 0 && t <= t_max &&
                       off <= (segment.type == CurveType::flat ? 4 : 0.25) * r + 1e-5 * place.t * length(direction);
    if (!there) return false;
    place = {t, u, std::clamp(h, -1.0, 1.0)};
    return true;
}

CurveFrame curve_frame(const CurveSegment& segment, const DVec3& direction, double u, double h,
                       const DVec3& ray_point) {
    const DVec3 tangent = segment.tangent(u);
    CurveFrame frame;
    frame.along = normalize(tangent);
    if (segment.type == CurveType::ribbon) {
        frame.across = normalize(cross(tangent, segment.normal(u)));
        frame.normal = cross(frame.across, frame.along);
        frame.offset = frame.across * h;
        return frame;
    }
    DVec3 across = cross(direction, tangent);
    // the ray runs along the curve
    if (!(length(across) > 0)) across = cross(direction, DVec3{direction.y, -direction.z, direction.x});
    frame.across = normalize(across);
    const DVec3 facing = normalize(cross(frame.across, tangent));
    frame.normal = facing;
    frame.offset = frame.across * h;
    if (segment.type == CurveType::cylinder) {
        const double depth = std::sqrt(std::max(1 - h * h, 0.0));
        const bool inside = dot(ray_point - segment.point(u), facing) < 0;
        frame.offset = frame.offset + facing * (inside ? -depth : depth);
        frame.normal = frame.offset;
    }
    return frame;
}

}  // namespace raylex::transport
