// Shape directives into loaded geometry, still in the space it was written in.
#pragma once

#include <functional>
#include <vector>

#include "display/services/registry.h"
#include "transport/files/input_file.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

/// What surrounds a Shape directive.
struct ShapeContext {
    Transform object_to_world;
    bool reverse_orientation = false;
    SearchPath search;
};

/// The shapes of one directive. Material, area light, label and alpha are the caller's business.
using ShapeFactory = std::function<Result<std::vector<SceneShape>>(
    const ParameterSet& parameters, const ShapeContext& context, std::vector<Error>& warnings)>;
/// The shapes by their names in pbrt; plugins add theirs, as meshes (finish_mesh()) or as the kinds there are.
Registry<ShapeFactory>& shape_registry();

/// What every mesh goes through: `mesh` has its kind, location, positions and indices, and normals and texture
/// coordinates if any, in the object's space, where they stay; normals that are no numbers are computed from the faces,
/// and faces without area are left out, each with a warning that says `what` it was of. Where the shape stands in the
/// world is `context`'s business, and what that does to its vertices place_mesh()'s, when the scene is built.
///
/// The caller has checked that indices and counts fit, and that positions are finite.
Result<std::vector<SceneShape>> finish_mesh(SceneShape mesh, const std::string& what, const ShapeContext& context,
                                            std::vector<Error>& warnings);

/// The shapes of one directive: none when nothing of positive area is left (a warning says so), two for a mesh file
/// that holds triangles and quadrilaterals. Material, area light and label are the caller's business.
///
/// Conventions of pbrt: vertices and normals are floats as written; normals change sign under ReverseOrientation; the
/// surface's own side turns (flip_normal) under ReverseOrientation xor a transformation that swaps handedness.
Result<std::vector<SceneShape>> make_shapes(const std::string& type, const ParameterSet& parameters,
                                            const ShapeContext& context, std::vector<Error>& warnings);

}  // namespace raylex::transport
