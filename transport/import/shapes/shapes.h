// Turns Shape directives into loaded geometry, in the space of the directive.
#pragma once

#include <functional>
#include <vector>

#include "display/services/registry.h"
#include "transport/files/input_file.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

/// The graphics state around a Shape directive.
struct ShapeContext {
    Transform object_to_world;
    bool reverse_orientation = false;
    SearchPath search;
};

/// Makes the shapes of one directive. The caller sets material, area light, label and alpha.
using ShapeFactory = std::function<Result<std::vector<SceneShape>>(
    const ParameterSet& parameters, const ShapeContext& context, std::vector<Error>& warnings)>;
/// The shapes by pbrt's names; plugins add theirs as meshes (finish_mesh()) or as existing kinds.
Registry<ShapeFactory>& shape_registry();

/// Completes a mesh. `mesh` has its kind, location, positions and indices, and optionally normals and texture
/// coordinates, in the object's space, where they stay. Normals that are not finite are computed from the faces, and
/// faces without area are dropped, each with a warning that contains `what`. `context` contains the placement in the
/// world; place_mesh() applies it to vertices when the scene is built.
/// || The caller has checked that indices and counts fit, and that positions are finite.
Result<std::vector<SceneShape>> finish_mesh(SceneShape mesh, const std::string& what, const ShapeContext& context,
                                            std::vector<Error>& warnings);

/// Makes the shapes of one directive: none if no positive area is left (with a warning), two for a mesh file with
/// triangles and quadrilaterals. The caller sets material, area light and label.
/// || Conventions of pbrt: vertices and normals are floats as written. Normals change sign under ReverseOrientation.
/// The surface's own side turns (flip_normal) under ReverseOrientation xor a transformation that swaps handedness.
Result<std::vector<SceneShape>> make_shapes(const std::string& type, const ParameterSet& parameters,
                                            const ShapeContext& context, std::vector<Error>& warnings);

}  // namespace raylex::transport
