// Curves: cubic Bezier segments with a width, as Embree intersects them and as rendering uses them.
//
// Embree finds the segment that a ray hits. The place on it is computed here, in double, by Newton's method. The start
// is rounded, so that the last bits of Embree's result do not matter. Where the method does not converge (silhouettes
// of tubes, bends that Embree's pieces cut off), Embree's own numbers remain.
//
// The solution is a point C(u) of the centre line and a point P of the ray with (P - C) . C' = 0, and
//     flat      (P - C) . d = 0        the ribbon that faces the ray
//     cylinder  |P - C| = r(u)         the tube swept by circles across the tangent
//     ribbon    (P - C) . N(u) = 0     the ribbon across the tangent and the normal
// where |P - C| is at most r(u), half the width. h = -1..1 is the offset of P across the curve, in units of r.
#pragma once

#include <cstdint>
#include <vector>

#include "transport/geometry/ray.h"
#include "transport/geometry/surface_point.h"
#include "transport/math/matrix34.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

/// A control point as Embree reads it.
struct CurvePoint {
    float x = 0, y = 0, z = 0, radius = 0;
};

struct CurveSegment {
    CurveType type = CurveType::flat;
    DVec3 points[4], normals[4];  ///< control points; normals for ribbons only
    double radius_start = 0, radius_end = 0;

    [[nodiscard]] DVec3 point(double u) const;
    [[nodiscard]] DVec3 derivative(double u) const;
    [[nodiscard]] DVec3 second_derivative(double u) const;
    /// The derivative at u. Where it is 0 (control points that coincide), a direction along the curve.
    [[nodiscard]] DVec3 tangent(double u) const;
    [[nodiscard]] double radius(double u) const { return radius_start + (radius_end - radius_start) * u; }
    /// The normal at u, not normalised.
    [[nodiscard]] DVec3 normal(double u) const;
    [[nodiscard]] DVec3 normal_derivative(double u) const;
};

/// All curves of one SceneShape, in the space in which they are traced.
struct CurveBatch {
    CurveType type = CurveType::flat;
    const CurvePoint* points = nullptr;       ///< Embree's buffer, or own_points
    const StoredVec3* normals = nullptr;      ///< one per control point; null except for ribbons
    std::vector<std::uint32_t> first_points;  ///< [segment]
    std::uint32_t splits = 1;                 ///< Embree primitives per segment; more than 1 for bent ribbons
    std::vector<CurvePoint> own_points;       ///< if Embree stores split ones
    std::vector<StoredVec3> own_normals;
    bool mirrored = false;  ///< the placement swaps handedness: v runs against h
    bool reversed = false;  ///< the outside is the side that rays do not come from (ReverseOrientation)
    double extent = 0;      ///< the largest absolute coordinate

    /// The whole segment that the primitive is part of.
    [[nodiscard]] CurveSegment segment(std::uint32_t primitive) const;
    /// The parameter u of the segment at `u` of the primitive.
    [[nodiscard]] double along(std::uint32_t primitive, double u) const { return (primitive % splits + u) / splits; }
};

/// The result of place_curves(): control points for Embree, and the beginnings of segments.
struct PlacedCurves {
    std::vector<CurvePoint> points;
    std::vector<StoredVec3> normals;
    std::vector<std::uint32_t> first_points;
    double extent = 0;
    std::size_t dropped = 0;  ///< segments whose control points coincide, or that have no width
    /// the placement does not keep circles: widths are scaled by the mean of its scales
    bool widths_are_means = false;
    std::uint32_t splits = 1;  ///< the number of parts into which each segment is to be split for Embree
    /// the number of straight pieces into which Embree cuts each segment of a flat curve
    unsigned pieces = 1;
};

/// Checks counts that do not match, numbers that are not finite, negative widths, and normals of ribbons that are zero.
Status check_curves(const SceneShape& shape);

/// Transforms control points by `placement` in double, rounds them, and scales widths. Errors: those of check_curves(),
/// a placement without inverse, numbers beyond the range of float.
Result<PlacedCurves> place_curves(const SceneShape& shape, const Transform& placement);

/// Splits each segment of the curves into `splits` segments; `splits` of the result is 1.
PlacedCurves split_curves(const PlacedCurves& curves);

/// The place at which a ray meets a curve.
struct CurvePlace {
    double t = 0, u = 0, h = 0;
};

/// Replaces the intersector's `place` by the point at which the ray meets the segment. Returns false and leaves `place`
/// unchanged if no such point within `t_max` is found.
bool meet_curve(const CurveSegment& segment, const DVec3& origin, const DVec3& direction, double t_max,
                CurvePlace& place);

/// Unit directions at a hit: across the curve towards h = 1, out of the surface, along the curve.
struct CurveFrame {
    DVec3 across, normal, along;
    DVec3 offset;  ///< from the centre line to the point, in units of the radius
};
/// `ray_point` is approximately the point at which the ray met the surface; it decides the side of a tube.
CurveFrame curve_frame(const CurveSegment& segment, const DVec3& direction, double u, double h, const DVec3& ray_point);

/// The distance off a curve, along its normal, at which a ray must start. A fibre is one event: rays that pass through
/// it start behind it, as in pbrt-v4. For a ribbon that faces rays a step of r is enough: after a step along the normal
/// from (h r, 0) to (h r, r), no direction on that side comes within r of the axis. Through a tube it is 2 r. A quarter
/// more allows for bends and tapers. Ribbons with a fixed orientation need the rounding of their width in Embree's
/// single precision.
constexpr Real curve_offset(CurveType type, Real radius) {
    return radius * (type == CurveType::flat ? Real(1.25) : type == CurveType::cylinder ? Real(2.5) : Real(0x1p-6));
}

}  // namespace raylex::transport
