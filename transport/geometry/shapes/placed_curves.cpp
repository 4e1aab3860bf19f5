// Curves in the space in which they are traced.
#include "transport/geometry/shapes/curve.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "display/services/elementary.h"
#include "display/services/short_number.h"

namespace raylex::transport {
namespace {

/// The mean scale of a linear map; `similarity` receives whether it keeps circles.
double scale_of(const Transform& placement, bool& similarity) {
    const Matrix4& m = placement.matrix();
    const DVec3 x{m[0][0], m[1][0], m[2][0]}, y{m[0][1], m[1][1], m[2][1]}, z{m[0][2], m[1][2], m[2][2]};
    const double mean = (dot(x, x) + dot(y, y) + dot(z, z)) / 3;
    const double tolerance = 1e-4 * mean;  // files write matrices with six digits
    similarity = true;
    for (const double off : {dot(x, y), dot(y, z), dot(z, x), dot(x, x) - mean, dot(y, y) - mean, dot(z, z) - mean})
        similarity = similarity && std::abs(off) < tolerance;
    return std::sqrt(mean);
}

/// Appends control points of the normals along a segment: the cubic whose ends have the direction and constant speed of
/// the great circle between the normals (pbrt interpolates along it).
void append_normals(std::vector<StoredVec3>& normals, const DVec3& start, const DVec3& end) {
    const double cosine = std::clamp(dot(start, end), -1.0, 1.0), sine = std::sqrt(1 - cosine * cosine);
    const double third = sine > 1e-6 ? elementary::acos(cosine) / (3 * sine) : 1.0 / 3;
    normals.push_back(to_float((start + (end - start * cosine) * third).to_real()));
    normals.push_back(to_float((end - (end * cosine - start) * third).to_real()));
    normals.push_back(to_float(end.to_real()));
}

/// The number of straight pieces that stay within a twentieth of the width (pbrt-v4's measure): the chord of one of N
/// pieces is off by at most |C''| / (8 N^2).
double pieces_of(const CurvePoint* p) {
    double bend = 0, radius = 0;
    for (int i = 0; i < 4; ++i) radius = std::max(radius, static_cast<double>(p[i].radius));
    for (int i = 0; i < 2; ++i) {
        const auto second = [&](float a, float b, float c) { return static_cast<double>(a) - 2.0 * b + c; };
        bend =
            std::max(bend, length(DVec3{second(p[i].x, p[i + 1].x, p[i + 2].x), second(p[i].y, p[i + 1].y, p[i + 2].y),
                                        second(p[i].z, p[i + 1].z, p[i + 2].z)}));
    }
    return radius > 0 ? std::sqrt(6 * bend / (8 * 0.1 * radius)) : 1;
}

/// The number of parts of at most 0.2 radians. Embree replaces the edges of a ribbon by cubics with the tangents at its
/// ends, which is accurate for short arcs only. The legs of the control polygon turn at least as far as the segment,
/// and so do those of the normals.
double splits_of(const CurvePoint* p, const DVec3& start, const DVec3& end) {
    const auto leg = [p](int i) {
        return DVec3{static_cast<double>(p[i + 1].x) - p[i].x, static_cast<double>(p[i + 1].y) - p[i].y,
                     static_cast<double>(p[i + 1].z) - p[i].z};
    };
    const auto between = [](const DVec3& a, const DVec3& b) {
        const double lengths = length(a) * length(b);
        return lengths > 0 ? elementary::acos(std::clamp(dot(a, b) / lengths, -1.0, 1.0)) : 0;
    };
    const double turn = between(leg(0), leg(1)) + between(leg(1), leg(2));
    return std::max(turn, between(start, end)) / 0.2;
}

/// The polar form of a cubic. It gives the control points of the part between a and b.
DVec3 blossom(const DVec3 (&p)[4], double a, double b, double c) {
    const auto mix = [](const DVec3& from, const DVec3& to, double t) { return from * (1 - t) + to * t; };
    const DVec3 q[3] = {mix(p[0], p[1], a), mix(p[1], p[2], a), mix(p[2], p[3], a)};
    return mix(mix(q[0], q[1], b), mix(q[1], q[2], b), c);
}

class CurvePlacer {
  public:
    CurvePlacer(const SceneShape& shape, const Transform& placement) : shape_(shape), placement_(placement) {
        bool similarity = true;
        scale_ = scale_of(placement, similarity);
        placed_.widths_are_means = !similarity;
        placed_.points.reserve(shape.positions.size());
        placed_.first_points.reserve(shape.positions.size() / 3);
    }

    Result<PlacedCurves> place() {
        for (std::size_t k = 0; k < shape_.indices.size(); ++k) {
            const std::size_t begin = shape_.indices[k];
            const std::size_t end = k + 1 < shape_.indices.size() ? shape_.indices[k + 1] : shape_.positions.size();
            if (Status s = place_curve(k, begin, (end - begin) / 3); !s) return s.error();
        }
        // Four pieces cost no more than one: Embree processes at least as many at a time.
        placed_.splits = static_cast<std::uint32_t>(std::clamp(std::ceil(splits_), 1.0, 16.0));
        placed_.pieces = static_cast<unsigned>(std::clamp(std::ceil(pieces_), 4.0, 16.0));
        return std::move(placed_);
    }

  private:
    Status place_curve(std::size_t number, std::size_t begin, std::size_t segments) {
        const std::size_t first = placed_.points.size();
        const double radius0 = 0.5 * scale_ * shape_.curve_widths[number].x,
                     radius1 = 0.5 * scale_ * shape_.curve_widths[number].y;
        for (std::size_t i = 0; i <= 3 * segments; ++i) {
            const double s = static_cast<double>(i) / static_cast<double>(3 * segments);
            const StoredVec3 p = to_float(placement_.point_in_double(shape_.positions[begin + i]));
            const float radius = static_cast<float>(radius0 + (radius1 - radius0) * s);
            if (!is_finite(p) || !std::isfinite(radius))
                return error_at(shape_.location, "control point " + std::to_string(i) + " of curve " +
                                                     std::to_string(number) +
                                                     " is not finite after the current transformation");
            placed_.points.push_back({p.x, p.y, p.z, radius});
            placed_.extent = std::max({placed_.extent, std::abs(double{p.x}) + radius, std::abs(double{p.y}) + radius,
                                       std::abs(double{p.z}) + radius});
        }
        for (std::size_t i = 0; i < segments; ++i) add_segment(first + 3 * i);
        if (shape_.curve_type == CurveType::ribbon)
            if (Status s = check_ribbon(number, first, segments); !s) return s;
        if (shape_.curve_type == CurveType::ribbon) place_normals((begin - number) / 3 + number, segments);
        return success();
    }
    /// Rejects ribbons that are too wide. Embree halves a ribbon until its pieces are as wide as long: a ray takes 0.1
    /// ms for a ribbon that is 10^4 times as wide as long, 0.4 ms at 10^5, 1.5 ms at 10^6, and never ends at 10^8. No
    /// scene needs such a ribbon.
    Status check_ribbon(std::size_t number, std::size_t first, std::size_t segments) {
        constexpr double most = 1e5;
        for (std::size_t i = 0; i < segments; ++i) {
            const CurvePoint* p = placed_.points.data() + first + 3 * i;
            double length = 0;
            for (int k = 1; k < 4; ++k)
                length = std::max({length, std::abs(double{p[k].x} - p[0].x), std::abs(double{p[k].y} - p[0].y),
                                   std::abs(double{p[k].z} - p[0].z)});
            const double width = 2 * double{std::max(p[0].radius, p[3].radius)};
            if (length > 0 && width > most * length)  // ribbons without length are omitted
                return error_at(shape_.location,
                                "segment " + std::to_string(i) + " of ribbon " + std::to_string(number) +
                                    " is more than 10^5 times as wide (" + short_number(width) + ") as it is long (" +
                                    short_number(length) + "); expected at most that",
                                "a patch, such as a bilinearmesh, can have any width");
        }
        return success();
    }
    void add_segment(std::size_t first) {
        const CurvePoint* p = placed_.points.data() + first;
        const auto same = [&](const CurvePoint& q) { return q.x == p->x && q.y == p->y && q.z == p->z; };
        if ((same(p[1]) && same(p[2]) && same(p[3])) || (p[0].radius <= 0 && p[3].radius <= 0)) {
            ++placed_.dropped;
            return;
        }
        placed_.first_points.push_back(static_cast<std::uint32_t>(first));
        pieces_ = std::max(pieces_, pieces_of(p));
    }
    void place_normals(std::size_t first, std::size_t segments) {
        const auto at = [&](std::size_t i) { return normalize(DVec3(placement_.normal(shape_.normals[first + i]))); };
        placed_.normals.push_back(to_float(at(0).to_real()));
        const CurvePoint* points = placed_.points.data() + placed_.normals.size() - 1;
        for (std::size_t i = 0; i < segments; ++i) {
            append_normals(placed_.normals, at(i), at(i + 1));
            splits_ = std::max(splits_, splits_of(points + 3 * i, at(i), at(i + 1)));
        }
    }

    const SceneShape& shape_;
    const Transform& placement_;
    PlacedCurves placed_;
    double scale_ = 1, pieces_ = 1, splits_ = 1;
};

}  // namespace

Status check_curves(const SceneShape& shape) {
    const bool ribbon = shape.curve_type == CurveType::ribbon;
    const std::size_t curves = shape.indices.size(), points = shape.positions.size();
    const auto fail = [&](const std::string& message) { return error_at(shape.location, message); };
    if (points > 0xffffffffu) return fail("more than 2^32 control points in one group of curves");
    if (shape.curve_widths.size() != curves)
        return fail(std::to_string(shape.curve_widths.size()) + " pairs of widths for " + std::to_string(curves) +
                    " curves; expected one each");
    for (std::size_t k = 0; k < curves; ++k) {
        const std::size_t begin = shape.indices[k], end = k + 1 < curves ? shape.indices[k + 1] : points;
        if (begin >= end || end > points || (end - begin) % 3 != 1 || end - begin < 4 || (k == 0 && begin != 0))
            return fail("curve " + std::to_string(k) +
                        " has a number of positions that is not 3 n + 1; expected whole segments");
        const StoredVec2 width = shape.curve_widths[k];
        if (!(width.x >= 0 && width.y >= 0) || !std::isfinite(width.x) || !std::isfinite(width.y))
            return fail("a width of curve " + std::to_string(k) + " is negative or not finite; expected at least 0");
    }
    for (std::size_t i = 0; i < points; ++i)
        if (!is_finite(shape.positions[i]))
            return fail("control point " + std::to_string(i) + " of the curves is not finite; expected real numbers");
    const std::size_t normals = ribbon && points >= curves ? (points - curves) / 3 + curves : 0;
    if (shape.normals.size() != normals)
        return fail(std::to_string(shape.normals.size()) + " normals of curves; expected " + std::to_string(normals) +
                    ": ribbons have one at each end of every segment, other curves have none");
    for (std::size_t i = 0; i < normals; ++i)
        if (!is_finite(shape.normals[i]) || shape.normals[i] == StoredVec3())
            return fail("normal " + std::to_string(i) + " of the ribbons is zero or not finite; expected a direction");
    return success();
}

Result<PlacedCurves> place_curves(const SceneShape& shape, const Transform& placement) {
    if (!placement.invertible()) return error_at(shape.location, "the shape's transform has no inverse");
    if (Status s = check_curves(shape); !s) return s.error();
    return CurvePlacer(shape, placement).place();
}

PlacedCurves split_curves(const PlacedCurves& curves) {
    PlacedCurves split;
    const double n = curves.splits;
    for (const std::uint32_t first : curves.first_points) {
        const CurvePoint* p = curves.points.data() + first;
        DVec3 points[4], normals[4];
        for (int i = 0; i < 4; ++i) points[i] = {p[i].x, p[i].y, p[i].z};
        for (std::size_t i = 0; i < 4 && !curves.normals.empty(); ++i) normals[i] = DVec3(curves.normals[first + i]);
        for (std::uint32_t piece = 0; piece < curves.splits; ++piece) {
            split.first_points.push_back(static_cast<std::uint32_t>(split.points.size()));
            const double a = piece / n, b = (piece + 1) / n;
            for (int i = 0; i < 4; ++i) {
                const double x = i > 2 ? b : a, y = i > 1 ? b : a, z = i > 0 ? b : a;
                const StoredVec3 q = to_float(blossom(points, x, y, z).to_real());
                const double u = (x + y + z) / 3, start = p[0].radius, end = p[3].radius;
                split.points.push_back({q.x, q.y, q.z, static_cast<float>(start + (end - start) * u)});
                if (!curves.normals.empty()) split.normals.push_back(to_float(blossom(normals, x, y, z).to_real()));
            }
        }
    }
    return split;
}

}  // namespace raylex::transport
