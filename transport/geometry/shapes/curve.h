// Curves: cubic Bezier segments with a width, as Embree meets them and as rendering sees them.
//
// Embree says which segment a ray meets. Where on it is computed here, in double, by Newton's method from a start that
// is rounded so that the last bits of Embree's answer do not matter; where that does not settle (silhouettes of tubes,
// bends that Embree's pieces cut off) Embree's own numbers stay.
//
// A point C(u) of the centre line is where the ray's point P stands across the tangent, (P - C) . C' = 0, and
//     flat      (P - C) . d = 0        the ribbon that faces the ray
//     cylinder  |P - C| = r(u)         the tube swept by circles across the tangent
//     ribbon    (P - C) . N(u) = 0     the ribbon across the tangent and the normal
// with |P - C| at most r(u), half the width. h = -1..1 is how far aside P is, in units of r.
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
    DVec3 points[4], normals[4];  ///< control points; normals of ribbons alone
    double radius_start = 0, radius_end = 0;

    [[nodiscard]] DVec3 point(double u) const;
    [[nodiscard]] DVec3 derivative(double u) const;
    [[nodiscard]] DVec3 second_derivative(double u) const;
    /// The derivative, or where it is 0 (control points that coincide) a direction along the curve.
    [[nodiscard]] DVec3 tangent(double u) const;
    [[nodiscard]] double radius(double u) const { return radius_start + (radius_end - radius_start) * u; }
    /// Not normalised.
    [[nodiscard]] DVec3 normal(double u) const;
    [[nodiscard]] DVec3 normal_derivative(double u) const;
};

/// All curves of one SceneShape where they are traced.
struct CurveBatch {
    CurveType type = CurveType::flat;
    const CurvePoint* points = nullptr;       ///< Embree's, or own_points
    const StoredVec3* normals = nullptr;      ///< one a control point; null but for ribbons
    std::vector<std::uint32_t> first_points;  ///< [segment]
    std::uint32_t splits = 1;                 ///< Embree's primitives a segment; more than 1 for bent ribbons
    std::vector<CurvePoint> own_points;       ///< where Embree has others
    std::vector<StoredVec3> own_normals;
    bool mirrored = false;  ///< the placement swaps handedness: v goes the other way across than h
    bool reversed = false;  ///< outside is where rays do not come from (ReverseOrientation)
    double extent = 0;      ///< the largest coordinate

    /// That the primitive is of, whole.
    [[nodiscard]] CurveSegment segment(std::uint32_t primitive) const;
    /// The segment's u at `u` of the primitive.
    [[nodiscard]] double along(std::uint32_t primitive, double u) const { return (primitive % splits + u) / splits; }
};

/// What place_curves() makes: control points for Embree, and where segments begin.
struct PlacedCurves {
    std::vector<CurvePoint> points;
    std::vector<StoredVec3> normals;
    std::vector<std::uint32_t> first_points;
    double extent = 0;
    std::size_t dropped = 0;        ///< segments whose control points coincide, or that have no width
    bool widths_are_means = false;  ///< the placement does not keep circles: widths go by the mean of its scales
    std::uint32_t splits = 1;       ///< into how many segments each is to be split for Embree
    unsigned pieces = 1;            ///< into how many straight ones Embree cuts each segment of a flat curve
};

/// Counts that do not fit, numbers that are not finite, negative widths, normals of ribbons without direction.
Status check_curves(const SceneShape& shape);

/// Control points through `placement` in double, then rounded; widths by its scale. Errors: those of
/// check_curves(), a placement without inverse, what leaves the range of float.
Result<PlacedCurves> place_curves(const SceneShape& shape, const Transform& placement);

/// The same curves with each segment split into `splits`; those are the result's splits no more.
PlacedCurves split_curves(const PlacedCurves& curves);

/// Where a ray meets a curve.
struct CurvePlace {
    double t = 0, u = 0, h = 0;
};

/// Takes `place` from what the intersector found to where the ray meets the segment; false, and `place` unchanged,
/// where no such point within `t_max` is found.
bool meet_curve(const CurveSegment& segment, const DVec3& origin, const DVec3& direction, double t_max,
                CurvePlace& place);

/// Directions at a hit, unit: across the curve towards h = 1, out of the surface, along the curve.
struct CurveFrame {
    DVec3 across, normal, along;
    DVec3 offset;  ///< from the centre line to the point, in units of the radius
};
/// `ray_point`: about where the ray met the surface; says on which side of a tube that is.
CurveFrame curve_frame(const CurveSegment& segment, const DVec3& direction, double u, double h, const DVec3& ray_point);

/// How far a ray must start off a curve along its normal. A fibre is one event: what goes through it starts behind it,
/// as in pbrt-v4. From a ribbon that faces rays a step of r is enough (from (h r, 0) a step along the normal to
/// (h r, r) leaves no direction on that side that comes within r of the axis); through a tube it is 2 r. A quarter more
/// is for bends and tapers. Ribbons that stand still need what Embree's single precision makes of their width.
constexpr Real curve_offset(CurveType type, Real radius) {
    return radius * (type == CurveType::flat ? Real(1.25) : type == CurveType::cylinder ? Real(2.5) : Real(0x1p-6));
}

}  // namespace raylex::transport
