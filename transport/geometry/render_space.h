// The space in which light transport computes: the axes and unit of the world of the scene file, with the origin moved
// to the scene.
//
// A float has 24 bits everywhere. A room at 1e6 times its size from the world's origin would keep 4 of them, so all
// coordinates of the world are moved in double before they are rounded (pbrt-v4's rendering space, "Physically Based
// Rendering", 4th edition, 5.1.1, for the translation only). pbrt moves the camera to the origin. raylex moves the
// point of the scene's bounds that is nearest to the camera. For a camera among the shapes both agree; a camera far
// away from a small scene does not cost the scene its digits.
//
// Between EmbreeScene, the tables and the integrators "world" means this space. For AOVs and headers the origin is
// added back in double.
#pragma once

#include "transport/math/matrix34.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

/// A box in double; empty by default.
struct DBounds {
    DVec3 lower{1e300, 1e300, 1e300}, upper{-1e300, -1e300, -1e300};
    [[nodiscard]] bool empty() const { return !(lower.x <= upper.x); }
    void add(const DVec3& p);
    /// Adds `box`, transformed by `placement`.
    void add(const DBounds& box, const Transform& placement);
    /// The point of the box nearest to `p`, rounded to 2^-16 of the box's extent, so that numbers of few digits keep
    /// all digits when they are moved by it. `p` itself for an empty box.
    [[nodiscard]] DVec3 nearest(const DVec3& p) const;
};

/// The bounds of a shape's own numbers, before its transform; numbers that are not finite are ignored.
DBounds object_bounds(const SceneShape& shape);

struct RenderSpace {
    DVec3 origin;  ///< in the world

    /// The space of a scene. It is the world itself if the camera's transform is unusable, which another check reports.
    static RenderSpace of(const SceneDescription& scene);

    /// `to_world`, for points relative to `pivot`, followed by the move from the world to this space.
    [[nodiscard]] Transform placed(const Transform& to_world, const DVec3& pivot = {}) const;
    /// `from_here` after the move from the world to this space: for matrices in headers and AOVs.
    [[nodiscard]] Matrix4 from_world(const Matrix4& from_here) const;
};

/// The point from which an object's instances store the coordinates of their shapes, so that objects defined far from
/// the origin of their own space lose no digits.
DVec3 pivot_of(const SceneObject& object);

}  // namespace raylex::transport
