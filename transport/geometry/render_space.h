// Where light transport computes: axes and unit of the world that the scene's file speaks of, with the origin moved to
// the scene.
//
// A float has 24 bits wherever it is. A room at 1e6 times its size from the world's origin would keep 4 of them; so all
// that stands in the world is moved in double before it is rounded (pbrt-v4's rendering space, "Physically Based
// Rendering", 4th edition, 5.1.1, for the translation only). pbrt moves the camera to the origin. Here it is the point
// of the scene's bounds nearest to the camera: the same for a camera among the shapes, and a camera far away from a
// small scene does not take the digits from it.
//
// Between EmbreeScene, the tables and the integrators "world" means this space. What leaves, as an AOV or in a header,
// has the origin added back in double.
#pragma once

#include "transport/math/matrix34.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

/// A box in double; empty by default.
struct DBounds {
    DVec3 lower{1e300, 1e300, 1e300}, upper{-1e300, -1e300, -1e300};
    [[nodiscard]] bool empty() const { return !(lower.x <= upper.x); }
    void add(const DVec3& p);
    /// Adds `box` as `placement` places it.
    void add(const DBounds& box, const Transform& placement);
    /// The point in it that is nearest to `p`, to 2^-16 of the box's extent, so that numbers of few digits keep them
    /// all when they are moved by it. `p` itself for an empty box.
    [[nodiscard]] DVec3 nearest(const DVec3& p) const;
};

/// Of a shape's own numbers, before its transform; numbers that are not finite are left out.
DBounds object_bounds(const SceneShape& shape);

struct RenderSpace {
    DVec3 origin;  ///< in the world

    /// Of a scene. The world's own origin where the camera's transform is unusable: that is an error of its own.
    static RenderSpace of(const SceneDescription& scene);

    /// `to_world` followed by the way from the world to here, of points given from `pivot`.
    [[nodiscard]] Transform placed(const Transform& to_world, const DVec3& pivot = {}) const;
    /// The inverse of the way from the world to here, then `from_here`: for matrices that leave.
    [[nodiscard]] Matrix4 from_world(const Matrix4& from_here) const;
};

/// The point around which an object's instances keep their shapes: objects whose definition stands far from the origin
/// of its own space lose no digits there.
DVec3 pivot_of(const SceneObject& object);

}  // namespace raylex::transport
