// What single precision can intersect: private to embree_scene.cpp. Embree ends the program, or finds what is not
// there, where numbers leave its range; so a scene that would take rays there is an error that names the shape,
// instance or camera.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "transport/embree/embree_scene.h"

namespace raylex::transport {

/// Errors name what is not finite, out of range or of the wrong number.
Status check_mesh(const SceneShape& shape, std::size_t corners_of_a_primitive);
Status check_quadric(const SceneShape& shape);
/// Whether a quadric lies within largest_coordinate.
Status check_extent(const SceneShape& shape, double extent);

/// That a mesh lies within largest_coordinate, where it stands.
Status check_extent(const SceneShape& shape, const std::vector<StoredVec3>& positions);

/// That no more than a thousand instances of an object stand at one place, or move alike: Embree cannot part them, and
/// its time grows with their square.
Status check_coincident(const SceneDescription& scene);

/// How far from the origin rays of this scene begin, beside those that begin on shapes.
double extent_without_shapes(const SceneDescription& scene, const RenderSpace& space);

/// Where instances stand, one after the other in time; made anew, as they are many.
struct InstancePlacements {
    const std::function<Transform(std::size_t instance, std::size_t step)>& at;
    const std::function<std::size_t(std::size_t instance)>& steps;  ///< 1 for what stands still
};

struct PlacedShapes {
    std::span<const ShapeGeometry> shapes;                 ///< top level, then those of every object in turn
    std::span<const std::optional<Bounds>> object_bounds;  ///< nothing: an empty object
    const InstancePlacements& instances;
};
/// That each instance lies in range, and that rays of the scene do in the instances' own spaces. What no number of a
/// ray may exceed. `extent`: how far from the origin rays begin, instances apart.
Result<Real> limit_of_rays(const SceneDescription& scene, const PlacedShapes& placed, double extent);

}  // namespace raylex::transport
