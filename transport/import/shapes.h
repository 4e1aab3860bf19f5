// Shape directives into loaded, transformed geometry.
#pragma once

#include <vector>

#include "transport/import/input_file.h"
#include "transport/scene/scene_description.h"

namespace raylex::transport {

/// What surrounds a Shape directive.
struct ShapeContext {
    Transform object_to_world;
    bool reverse_orientation = false;
    SearchPath search;
};

/// The shapes of one directive: none when nothing of positive area is left (a warning says so), two for a mesh file
/// that holds triangles and quadrilaterals. Material, area light and label are the caller's business.
///
/// Conventions of pbrt: vertices go through object_to_world in double and are then rounded to float; normals through
/// its inverse transpose, not normalised, and change sign under ReverseOrientation; the surface's own side turns
/// (flip_normal) under ReverseOrientation xor a transformation that swaps handedness.
Result<std::vector<SceneShape>> make_shapes(const std::string& type, const ParameterSet& parameters,
                                            const ShapeContext& context, std::vector<Error>& warnings);

}  // namespace raylex::transport
