// Spheres, disks and cylinders, full or partial, in double: rays come in as floats, so every difference that a float
// intersection loses (a small sphere far away, an origin just off the surface) is still there in 53 bits.
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
    bool partial = false;                      ///< something is cut away
    bool reversed = false;                     ///< normals point inwards (ReverseOrientation)
    Placement placement;

    Quadric() = default;
    /// From a quadric shape that `to_world` places; the shape's numbers must be finite, the transform invertible.
    Quadric(const SceneShape& shape, const Transform& to_world);

    /// Smallest t in (t_min, t_max) of origin + t direction (world), or false.
    bool intersect(const DVec3& origin, const DVec3& direction, double t_min, double t_max, double& t, double& u,
                   double& v) const;

    /// The point at (u, v) in the object's own space.
    [[nodiscard]] DVec3 object_point(double u, double v) const;
    /// Outward unit normal there, before `reversed`.
    [[nodiscard]] DVec3 object_normal(const DVec3& point) const;
    [[nodiscard]] DVec3 object_dpdu(const DVec3& point) const { return {-phi_max * point.y, phi_max * point.x, 0}; }
    [[nodiscard]] DVec3 object_dpdv(const DVec3& point) const;
    /// Surface area in the object's own space.
    [[nodiscard]] double object_area() const;
    /// (u, v) of a point on the surface, in the object's own space; what is cut away gets some (u, v) too.
    void parameters(const DVec3& point, double& u, double& v) const { static_cast<void>(accept(point, u, v)); }
    /// (u, v) of a point drawn uniformly by object-space area.
    void sample_area(double a, double b, double& u, double& v) const;
    /// The (a, b) that sample_area() takes to (u, v).
    void area_numbers(double u, double v, double& a, double& b) const;

    struct Point {
        DVec3 position, normal;  ///< world; the normal unit and oriented
        double area_scale = 1;   ///< world area per object-space area
    };
    [[nodiscard]] Point world_point(double u, double v) const;

    void bounds(DVec3& lower, DVec3& upper) const;  ///< world, conservative
    /// A length no smaller than any object-space coordinate that occurs, in world units: scales double rounding.
    [[nodiscard]] double extent() const;

  private:
    bool accept(const DVec3& p, double& u, double& v) const;
};

}  // namespace raylex::transport
