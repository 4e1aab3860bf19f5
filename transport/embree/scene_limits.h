// The limits of intersection in single precision; private to this folder. Where numbers leave its range, Embree ends
// the program or reports wrong hits. A scene that would trace such rays is an error that names the shape, instance or
// camera.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "transport/embree/embree_scene.h"

namespace raylex::transport {

/// Checks a mesh. Errors name the number that is not finite or out of range, or the array of the wrong size.
Status check_mesh(const SceneShape& shape, std::size_t corners_of_a_primitive);
Status check_quadric(const SceneShape& shape);
/// Checks that a quadric lies within largest_coordinate.
Status check_extent(const SceneShape& shape, double extent);

/// Checks that a placed mesh lies within largest_coordinate.
Status check_extent(const SceneShape& shape, const std::vector<StoredVec3>& positions);

/// Checks that at most a thousand instances of an object stand at one place, or move alike: Embree cannot separate
/// them, and its time grows with the square of their number.
Status check_coincident(const SceneDescription& scene);

/// The distance from the origin within which rays of this scene begin, apart from rays that begin on shapes.
double extent_without_shapes(const SceneDescription& scene, const RenderSpace& space);

/// The placements of instances, one per step of time. They are computed on demand, since there are many.
struct InstancePlacements {
    const std::function<Transform(std::size_t instance, std::size_t step)>& at;
    const std::function<std::size_t(std::size_t instance)>& steps;  ///< 1 for an instance that does not move
};

struct PlacedShapes {
    std::span<const ShapeGeometry> shapes;                 ///< top level, then those of every object in turn
    std::span<const std::optional<Bounds>> object_bounds;  ///< nothing: the object is empty
    const InstancePlacements& instances;
};
/// Checks that each instance lies in range, and that rays of the scene stay in range in the instances' own spaces.
/// Returns the bound on all coordinates of rays. `extent` is how far from the origin rays begin, apart from instances.
Result<Real> limit_of_rays(const SceneDescription& scene, const PlacedShapes& placed, double extent);

}  // namespace raylex::transport
