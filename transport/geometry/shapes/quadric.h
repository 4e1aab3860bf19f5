// Spheres, disks and cylinders, full or partial, in double. Rays are floats, so 53 bits keep every difference that a
// float intersection loses (a small sphere far away, an origin just off the surface).
//
// Parameters and (u, v) are pbrt-v4's ("Physically Based Rendering", 4th edition, chapter 6).
#pragma once

#include "transport/math/matrix34.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

struct Quadric {
    ShapeKind kind = ShapeKind::sphere;
    double radius = 1, z_min = -1, z_max = 1;  ///< sphere, cylinder
    double height = 0, inner_radius = 0;       ///< disk
    double phi_max = 0;                        ///< radians
    double theta_min = 0, theta_max = 0;       ///< sphere: angles from +z at z_min and z_max
    bool partial = false;                      ///< the shape is cut by z_min, z_max, phi_max or inner_radius
    bool reversed = false;                     ///< normals point inwards (ReverseOrientation)
    Placement placement;

    Quadric() = default;
    /// Makes a quadric shape, placed by `to_world`. The shape's numbers must be finite, the transform invertible.
    Quadric(const SceneShape& shape, const Transform& to_world);

    /// Finds the smallest t in (t_min, t_max) of origin + t direction (world); returns false if there is no hit.
    bool intersect(const DVec3& origin, const DVec3& direction, double t_min, double t_max, double& t, double& u,
                   double& v) const;

    /// The point at (u, v) in the object's own space.
    [[nodiscard]] DVec3 object_point(double u, double v) const;
    /// The outward unit normal at a point of the object's space, before `reversed`.
    [[nodiscard]] DVec3 object_normal(const DVec3& point) const;
    [[nodiscard]] DVec3 object_dpdu(const DVec3& point) const { return {-phi_max * point.y, phi_max * point.x, 0}; }
    [[nodiscard]] DVec3 object_dpdv(const DVec3& point) const;
    /// Surface area in the object's own space.
    [[nodiscard]] double object_area() const;
    /// (u, v) of a point on the surface, in the object's own space; points of parts that are cut away get some (u, v)
    /// too.
    void parameters(const DVec3& point, double& u, double& v) const { static_cast<void>(accept(point, u, v)); }
    /// (u, v) of a point drawn uniformly by object-space area.
    void sample_area(double a, double b, double& u, double& v) const;
    /// The random numbers (a, b) for which sample_area() returns (u, v).
    void area_numbers(double u, double v, double& a, double& b) const;

    struct Point {
        DVec3 position, normal;  ///< world; the normal unit and oriented
        double area_scale = 1;   ///< world area per object-space area
    };
    [[nodiscard]] Point world_point(double u, double v) const;

    void bounds(DVec3& lower, DVec3& upper) const;  ///< world, conservative
    /// A bound on the magnitude of all object-space coordinates, in world units: scales the rounding errors of double.
    [[nodiscard]] double extent() const;

  private:
    bool accept(const DVec3& p, double& u, double& v) const;
};

}  // namespace raylex::transport
